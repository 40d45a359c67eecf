// A recording's frames out of its file, whole or damaged, finished or not; also of the recording beside a clip.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <unordered_set>

#include "container/reader.h"
#include "container/sound.h"
#include "recording/layout.h"
#include "recording/lossless_video.h"

namespace kinora::recording {

/// How sure it is that a file holds a recording (0–100), and why. Reads the file's head. Never throws.
std::pair<int, std::string> recognise_recording(const std::filesystem::path& path);

/// The stored bytes of one picture, and what stands behind them.
struct StoredPicture {
  std::string codec; ///< V_FFV1 or V_MJPEG
  container::Bytes bytes;
};

/// Opening reads the whole file's structure once; memory holds a few dozen bytes for each block. Not thread-safe.
class RecordingFile {
public:
  /// Damaged bytes are passed over. Throws Error: kNotRecognised (no recording), kCorruptInput (its description, or
  /// every frame, is lost).
  explicit RecordingFile(const std::filesystem::path& path);

  const Description& description() const { return description_; }
  std::size_t frame_count() const { return frames_.size(); }
  const FrameRecord& record(std::size_t frame) const { return frames_[frame].record; }
  /// Frames that the recorder lost or dropped.
  std::size_t dropped() const;
  bool finished() const { return reader_.finished(); }
  const container::DamageList& damage() const { return reader_.damage(); }
  /// What any part of the file takes, by track.
  const std::map<std::string, std::uint64_t>& bytes_by_track() const { return bytes_by_track_; }
  std::uint64_t file_bytes() const { return reader_.file_bytes(); }
  bool has(Stream stream) const { return tracks_.contains(stream); }

  /// What its packets of sound are; null if it has none.
  const container::Track* sound_track() const;
  /// In the file's order.
  std::size_t sound_packet_count() const { return sound_blocks_.size(); }
  /// A packet of sound, its time from the description's start. Throws Error(kCorruptInput) if it is damaged: no
  /// frame's record knows it. Sound that somebody else has put into the file is given as it is.
  container::Payload read_sound(std::size_t packet);
  /// Packets of which nothing is there.
  std::size_t lost_sound_packets() const;

  /// The bytes of a picture, checked. Nothing if the frame has none. Throws Error(kCorruptInput), naming the frame.
  std::optional<StoredPicture> read(std::size_t frame, Stream stream);
  /// The pixels of an FFV1 picture. Throws Error(kCorruptInput), naming the frame; kMissingComponent.
  std::vector<std::byte> decode(std::size_t frame, Stream stream, const PictureShape& shape,
                                const container::Bytes& bytes);

private:
  struct Frame {
    FrameRecord record;
    std::int64_t block_time = 0;
  };
  using Place = std::pair<std::size_t, std::int64_t>; // of a track, and a time

  void find_tracks();
  void read_structure();
  [[noreturn]] void throw_lost(std::size_t frame, Stream stream, const char* why) const;

  container::Reader reader_;
  Description description_;
  std::optional<std::size_t> frame_track_;
  std::multimap<Stream, std::size_t> tracks_;
  std::optional<std::size_t> sound_track_;
  std::vector<Frame> frames_;
  std::multimap<Place, container::StoredBlock> blocks_;
  std::vector<container::StoredBlock> sound_blocks_;
  std::unordered_set<std::uint32_t> sound_checksums_; ///< of all packets that frames' records name
  std::size_t sound_packets_named_ = 0;
  std::map<std::string, std::uint64_t> bytes_by_track_;
  std::map<Stream, std::pair<PictureShape, std::unique_ptr<LosslessDecoder>>> decoders_;
};

/// Every picture of every frame, read, checked and decoded, and every packet of sound. Returns a sentence for each
/// frame that is damaged, for each gap in the frames' numbers that the camera's own losses do not explain, and for
/// sound that is damaged or missing.
std::vector<std::string> check_recording(RecordingFile& file, const std::function<void(std::size_t)>& before_frame);

/// The shape that a stream's pictures have.
PictureShape shape_of(const Description& description, Stream stream);

} // namespace kinora::recording
