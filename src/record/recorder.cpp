#include "record/recorder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "container/crc32c.h"
#include "core/error.h"
#include "core/parallel.h"
#include "recording/recording_file.h"

namespace kinora::record {

using recording::Stream;

namespace {

constexpr std::int64_t kClusterNs = 500'000'000; // what a crash may cost
constexpr std::size_t kClusterBytes = std::size_t{8} << 20;

const KinoraImage& image_of(const KinoraFrame& frame, Stream stream) {
  const KinoraImage* images[] = {&frame.color, &frame.depth, &frame.infrared, &frame.confidence, &frame.labels};
  return *images[static_cast<std::size_t>(stream)];
}

std::uint16_t track_id(Stream stream) {
  return static_cast<std::uint16_t>(recording::kFrameTrack + 1 + static_cast<int>(stream));
}

std::string text_of_size(int width, int height) { return fmt::format("{}x{}", width, height); }

} // namespace

Recorder::Recorder(const std::filesystem::path& path, const recording::Description& description,
                   const KinoraFrame& first, const container::Track* sound)
    : description_(description), jpeg_(first.color_jpeg != nullptr) {
  container::FileHead head;
  head.kind = recording::kRecordingKind;
  for (std::size_t s = 0; s < recording::kStreams; ++s) {
    const auto stream = static_cast<Stream>(s);
    const bool wanted = image_of(first, stream).data != nullptr || (stream == Stream::kLabels && description.has_masks);
    if (wanted) head.tracks.push_back(track_of(stream, stream == Stream::kColor && jpeg_));
  }
  if (sound != nullptr) {
    head.tracks.push_back(*sound);
    head.tracks.back().id = container::kSoundTrack;
    head.tracks.back().name = container::kCaptureSoundName;
  }
  head.tracks.push_back({recording::kFrameTrack, recording::kFrameCodec, "capture frames", {}, std::nullopt});
  const std::string json = recording::to_json(description);
  const auto bytes = std::as_bytes(std::span(json));
  head.attachments.push_back({recording::kDescriptionName,
                              "application/json",
                              "Calibration and streams of the recording",
                              {bytes.begin(), bytes.end()}});
  container::WriterOptions options;
  options.cluster_bytes = kClusterBytes;
  options.cluster_ns = kClusterNs;
  options.durable = true;
  writer_ = std::make_unique<container::Writer>(path, head, options);
}

container::Track Recorder::track_of(Stream stream, bool jpeg) {
  const recording::PictureShape shape = recording::shape_of(description_, stream);
  container::Track track;
  track.id = track_id(stream);
  track.name = recording::track_name(stream);
  track.codec = jpeg ? recording::kMjpegCodec : recording::kFfv1Codec;
  track.media.emplace();
  track.media->width = shape.width;
  track.media->height = shape.height;
  track.media->duration_ns = std::llround(1e9 / description_.frames_per_second);
  if (jpeg) return track;
  encoders_[stream] = recording::make_ffv1_encoder(shape);
  track.private_data = encoders_[stream]->private_data();
  return track;
}

std::string Recorder::misfit(const KinoraFrame& frame) const {
  if (jpeg_ && frame.color_jpeg == nullptr) return "its colour is no JPEG, as that of the first frame is";
  for (std::size_t s = 0; s < recording::kStreams; ++s) {
    const auto stream = static_cast<Stream>(s);
    const KinoraImage& image = image_of(frame, stream);
    const bool needed = stream == Stream::kColor || stream == Stream::kDepth;
    if (image.data == nullptr) {
      if (needed) return fmt::format("it has no {}", recording::track_name(stream));
      continue;
    }
    if (!encoders_.contains(stream) && !(stream == Stream::kColor && jpeg_))
      return fmt::format("it has {}, which the first frame had not", recording::track_name(stream));
    const recording::PictureShape shape = recording::shape_of(description_, stream);
    const int channels = shape.layout == recording::PixelLayout::kRgb8 ? 3 : 1;
    const auto type = shape.layout == recording::PixelLayout::kGray16 ? KINORA_PIXEL_U16 : KINORA_PIXEL_U8;
    if (image.width != shape.width || image.height != shape.height || image.channels != channels ||
        image.pixel_type != type)
      return fmt::format("{} is {}, not {} as the camera says", recording::track_name(stream),
                         text_of_size(image.width, image.height), text_of_size(shape.width, shape.height));
  }
  return {};
}

void Recorder::encode(Picture& picture, const KinoraFrame& frame) {
  if (picture.stream == Stream::kColor && jpeg_) {
    const auto* data = static_cast<const std::byte*>(frame.color_jpeg);
    picture.bytes.assign(data, data + frame.color_jpeg_bytes);
  } else {
    picture.bytes = encoders_.at(picture.stream)->encode(picture.image->data, picture.image->row_bytes);
  }
}

/// Blocks never go back, even where a device's clock does; the record keeps that.
std::int64_t Recorder::block_time(double time) {
  const double ns = (time - description_.start_time) * 1e9;
  const std::int64_t rounded = ns > 0 && ns < 9e18 ? std::llround(ns) : 0;
  last_time_ns_ = std::max(last_time_ns_, rounded);
  return last_time_ns_;
}

bool Recorder::write(const KinoraFrame& frame, const Arrival& arrival) {
  if (const std::string why = misfit(frame); !why.empty()) {
    write_problem(frame.index, frame.time, fmt::format("frame {} was not recorded: {}", frame.index, why), arrival);
    return false;
  }
  std::vector<Picture> pictures;
  for (std::size_t s = 0; s < recording::kStreams; ++s) {
    const auto stream = static_cast<Stream>(s);
    const KinoraImage& image = image_of(frame, stream);
    if (image.data != nullptr) pictures.push_back({stream, &image, {}});
  }
  parallel_for(pictures.size(), 1, [&](const Chunk& chunk) { encode(pictures[chunk.begin], frame); });
  recording::FrameRecord record;
  record.index = frame.index;
  record.time = frame.time;
  record.dropped_before = arrival.dropped_before;
  record.host_time_ns = arrival.host_time_ns;
  record.depth_unit = frame.depth_unit;
  if (frame.has_pose != 0) {
    record.camera_to_world.emplace();
    std::copy(std::begin(frame.camera_to_world), std::end(frame.camera_to_world), record.camera_to_world->begin());
  }
  const std::int64_t time_ns = block_time(frame.time);
  for (const Picture& picture : pictures) {
    writer_->write(track_id(picture.stream), time_ns, true, picture.bytes);
    record.parts.push_back({picture.stream, container::crc32c(picture.bytes)});
  }
  write_record(record, time_ns);
  return true;
}

void Recorder::write_record(recording::FrameRecord& record, std::int64_t time_ns) {
  record.sound = std::exchange(sound_, {});
  writer_->write(recording::kFrameTrack, time_ns, true, recording::encode_record(record));
}

void Recorder::write_sound(const container::Payload& packet) {
  if (packet.time_ns < 0) return;
  last_time_ns_ = std::max(last_time_ns_, packet.time_ns);
  writer_->write(container::kSoundTrack, last_time_ns_, true, packet.bytes);
  sound_.push_back(container::crc32c(packet.bytes));
}

void Recorder::write_problem(std::int64_t index, double time, const std::string& problem, const Arrival& arrival) {
  recording::FrameRecord record;
  record.dropped_before = arrival.dropped_before;
  record.host_time_ns = arrival.host_time_ns;
  record.index = index;
  record.time = std::isfinite(time) ? time : description_.start_time;
  record.problem = problem;
  write_record(record, block_time(record.time));
}

} // namespace kinora::record
