#include "recording/recording_file.h"

#include <fmt/format.h>

#include "container/crc32c.h"
#include "core/error.h"

namespace kinora::recording {
namespace {

std::string text_of(const container::Bytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

} // namespace

std::pair<int, std::string> recognise_recording(const std::filesystem::path& path) {
  try {
    const container::Reader reader(path, container::Reading::kSalvage);
    if (reader.tag(container::kKindTag) == kRecordingKind) return {100, "a Kinora recording"};
    if (reader.find_attachment(kDescriptionName) != nullptr) return {90, "a Kinora file with a recording inside"};
    return {0, "a Matroska file without a recording"};
  } catch (const std::exception& error) {
    return {0, error.what()};
  }
}

PictureShape shape_of(const Description& description, Stream stream) {
  const bool is_colors = stream == Stream::kColor || stream == Stream::kLabels || !description.depth_camera;
  const KinoraCamera& camera = is_colors ? description.camera : *description.depth_camera;
  const PixelLayout layout = stream == Stream::kColor                                  ? PixelLayout::kRgb8
                             : stream == Stream::kDepth || stream == Stream::kInfrared ? PixelLayout::kGray16
                                                                                       : PixelLayout::kGray8;
  return {camera.width, camera.height, layout};
}

RecordingFile::RecordingFile(const std::filesystem::path& path) : reader_(path, container::Reading::kSalvage) {
  const container::StoredAttachment* description = reader_.find_attachment(kDescriptionName);
  if (description == nullptr) {
    const bool said = reader_.tag(container::kKindTag) == kRecordingKind;
    throw Error(said ? ErrorCode::kCorruptInput : ErrorCode::kNotRecognised,
                fmt::format("{}: {}", reader_.name(),
                            said
                                ? "the recording's description (recording.json) is lost; without it nothing can be read"
                                : "holds no recording"));
  }
  description_ = description_from_json(text_of(reader_.read_attachment(*description)), reader_.name());
  find_tracks();
  read_structure();
  if (frames_.empty())
    throw Error(ErrorCode::kCorruptInput,
                fmt::format("{}: no frame of this recording is whole; it was cut before the first", reader_.name()));
}

void RecordingFile::find_tracks() {
  for (std::size_t i = 0; i < reader_.tracks().size(); ++i) {
    const container::StoredTrack& stored = reader_.tracks()[i];
    if (stored.ours && stored.track.codec == kFrameCodec) frame_track_ = i;
    const bool is_sound = stored.type == container::kSoundType && !stored.encoded_again && !stored.ours;
    if (is_sound && (!sound_track_ || stored.track.name == container::kCaptureSoundName)) sound_track_ = i;
    if (stored.ours || (stored.track.codec != kFfv1Codec && stored.track.codec != kMjpegCodec)) continue;
    for (std::size_t s = 0; s < kStreams; ++s)
      if (stored.track.name == track_name(static_cast<Stream>(s))) tracks_.emplace(static_cast<Stream>(s), i);
  }
  if (!frame_track_)
    throw Error(ErrorCode::kCorruptInput,
                fmt::format("{}: the track of the frames is lost; nothing can be read", reader_.name()));
}

void RecordingFile::read_structure() {
  container::StoredBlock block;
  while (reader_.next_block(block)) {
    const container::StoredTrack& stored = reader_.tracks()[block.track];
    bytes_by_track_[stored.track.name] += block.stored_bytes;
    if (block.track == *frame_track_) {
      const container::Payload payload = reader_.read_payload(block);
      const std::string location = fmt::format("{}: byte {}", reader_.name(), payload.offset);
      frames_.push_back({decode_record(payload.bytes, location), block.time_ns});
      const std::vector<std::uint32_t>& sound = frames_.back().record.sound;
      sound_checksums_.insert(sound.begin(), sound.end());
      sound_packets_named_ += sound.size();
    } else if (block.track == sound_track_) {
      if (block.lacing == container::Lacing::kNone) sound_blocks_.push_back(block);
    } else if (!stored.ours && block.lacing == container::Lacing::kNone) {
      blocks_.emplace(Place{block.track, block.time_ns}, block);
    }
  }
}

std::size_t RecordingFile::dropped() const {
  std::size_t count = 0;
  for (const Frame& frame : frames_) count += frame.record.dropped_before;
  return count;
}

void RecordingFile::throw_lost(std::size_t frame, Stream stream, const char* why) const {
  throw Error(ErrorCode::kCorruptInput,
              fmt::format("{}: frame {}: {} {}", reader_.name(), frame, track_name(stream), why));
}

std::optional<StoredPicture> RecordingFile::read(std::size_t frame, Stream stream) {
  const Frame& wanted = frames_[frame];
  const auto part = std::find_if(wanted.record.parts.begin(), wanted.record.parts.end(),
                                 [stream](const Part& candidate) { return candidate.stream == stream; });
  if (part == wanted.record.parts.end()) return std::nullopt;
  bool found = false;
  for (auto [track, end] = tracks_.equal_range(stream); track != end; ++track) {
    // Several frames may have one time, which Matroska rounds: the checksum tells them apart.
    for (auto [block, last] = blocks_.equal_range({track->second, wanted.block_time}); block != last; ++block) {
      found = true;
      container::Bytes bytes = reader_.read_block(block->second);
      if (container::crc32c(bytes) != part->checksum) continue;
      return StoredPicture{reader_.tracks()[track->second].track.codec, std::move(bytes)};
    }
  }
  throw_lost(frame, stream, found ? "is damaged" : "is lost");
}

const container::Track* RecordingFile::sound_track() const {
  return sound_track_ ? &reader_.tracks()[*sound_track_].track : nullptr;
}

container::Payload RecordingFile::read_sound(std::size_t packet) {
  const container::StoredBlock& block = sound_blocks_[packet];
  container::Payload payload{container::kSoundTrack, block.time_ns, true, reader_.read_block(block)};
  if (sound_packets_named_ > 0 && !sound_checksums_.contains(container::crc32c(payload.bytes)))
    throw Error(ErrorCode::kCorruptInput,
                fmt::format("{}: byte {}: a packet of sound is damaged", reader_.name(), block.offset));
  return payload;
}

std::size_t RecordingFile::lost_sound_packets() const {
  return sound_packets_named_ - std::min(sound_packets_named_, sound_blocks_.size());
}

std::vector<std::byte> RecordingFile::decode(std::size_t frame, Stream stream, const PictureShape& shape,
                                             const container::Bytes& bytes) {
  auto& [known_shape, decoder] = decoders_[stream];
  try {
    if (decoder == nullptr || known_shape != shape) {
      for (auto [track, end] = tracks_.equal_range(stream); track != end; ++track) {
        const container::Track& stored = reader_.tracks()[track->second].track;
        if (stored.codec == kFfv1Codec) decoder = make_ffv1_decoder(shape, stored.private_data);
      }
      known_shape = shape;
    }
    return decoder->decode(bytes);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCorruptInput) throw;
    throw_lost(frame, stream, error.what());
  }
}

/// That were recorded, as the numbers of those beside them say: what the camera lost is known.
static std::int64_t frames_missing_between(const FrameRecord& before, const FrameRecord& after) {
  return after.index - before.index - 1 - static_cast<std::int64_t>(after.dropped_before);
}

static void check_sound(RecordingFile& file, std::vector<std::string>& damaged) {
  for (std::size_t i = 0; i < file.sound_packet_count(); ++i) {
    try {
      file.read_sound(i);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCorruptInput) throw;
      damaged.emplace_back(error.what());
    }
  }
  if (const std::size_t lost = file.lost_sound_packets(); lost > 0)
    damaged.push_back(fmt::format("the recording lacks {} packets of sound", lost));
}

std::vector<std::string> check_recording(RecordingFile& file, const std::function<void(std::size_t)>& before_frame) {
  std::vector<std::string> damaged;
  for (std::size_t i = 0; i < file.frame_count(); ++i) {
    before_frame(i);
    if (const std::int64_t missing = i == 0 ? 0 : frames_missing_between(file.record(i - 1), file.record(i));
        missing > 0)
      damaged.push_back(fmt::format("the recording lacks {} frames before frame {}", missing, file.record(i).index));
    try {
      for (std::size_t s = 0; s < kStreams; ++s) {
        const auto stream = static_cast<Stream>(s);
        const std::optional<StoredPicture> picture = file.read(i, stream);
        if (picture && picture->codec == kFfv1Codec)
          file.decode(i, stream, shape_of(file.description(), stream), picture->bytes);
      }
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCorruptInput) throw;
      damaged.emplace_back(error.what());
    }
  }
  check_sound(file, damaged);
  return damaged;
}

} // namespace kinora::recording
