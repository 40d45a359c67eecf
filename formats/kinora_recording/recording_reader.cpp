#include "kinora_recording/recording_reader.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "core/error.h"
#include "core/image_codec.h"
#include "sound/plugin_sound.h"

namespace kinora::formats {

using recording::PictureShape;
using recording::PixelLayout;
using recording::Stream;

namespace {

KinoraImage view_of(const PictureShape& shape, const void* pixels) {
  KinoraImage view{};
  view.width = shape.width;
  view.height = shape.height;
  view.channels = shape.layout == PixelLayout::kRgb8 ? 3 : 1;
  view.pixel_type = shape.layout == PixelLayout::kGray16 ? KINORA_PIXEL_U16 : KINORA_PIXEL_U8;
  view.row_bytes = recording::bytes_per_pixel(shape.layout) * static_cast<std::size_t>(shape.width);
  view.data = pixels;
  return view;
}

} // namespace

RecordingReader::RecordingReader(const std::filesystem::path& path, bool read_masks)
    : name_(path.string()), read_masks_(read_masks), file_(path) {
  for (const recording::Label& label : file_.description().labels)
    labels_.push_back({label.label, label.name.c_str(), label.kind.c_str()});
  if (!file_.finished())
    warnings_.push_back(name_ +
                        ": was not finished; what is whole is read; kinora recover makes a complete file of it");
  if (!file_.damage().empty())
    warnings_.push_back(name_ + ": " + std::to_string(file_.damage().bytes()) +
                        " bytes are damaged and passed over; kinora recover says more");
  if (file_.dropped() > 0)
    warnings_.push_back(name_ + ": " + std::to_string(file_.dropped()) + " frames were dropped while it was recorded");
  put_in_order();
  warning_table_.set(warnings_);
}

/// A camera's clock may have run backwards; the file keeps what it said.
void RecordingReader::put_in_order() {
  order_.resize(file_.frame_count());
  std::iota(order_.begin(), order_.end(), 0);
  const auto earlier = [this](std::size_t a, std::size_t b) { return file_.record(a).time < file_.record(b).time; };
  if (std::is_sorted(order_.begin(), order_.end(), earlier)) return;
  warnings_.push_back(name_ + ": the times are out of order; frames are taken in order of time");
  std::stable_sort(order_.begin(), order_.end(), earlier);
}

void RecordingReader::fill_info(KinoraCaptureInfo& info) const {
  const recording::Description& description = file_.description();
  info.frame_count = static_cast<std::int64_t>(file_.frame_count());
  info.start_time = description.start_time;
  info.frames_per_second = description.frames_per_second;
  info.camera = description.camera;
  info.has_poses = description.has_poses ? 1 : 0;
  info.has_masks = description.has_masks && read_masks_ ? 1 : 0;
  info.labels = labels_.data();
  info.label_count = labels_.size();
  warning_table_.fill(info);
  if (!description.depth_camera) return;
  if (info.struct_size < sizeof(KinoraCaptureInfo))
    throw Error(ErrorCode::kFailure, "the host is too old for depth that is not registered to colour");
  info.has_depth_camera = 1;
  info.depth_camera = *description.depth_camera;
  std::copy(description.depth_to_color.begin(), description.depth_to_color.end(), info.depth_to_color);
}

KinoraStatus RecordingReader::next(KinoraFrame& frame) {
  if (next_ >= file_.frame_count()) return KINORA_END;
  frame.index = static_cast<std::int64_t>(next_);
  const std::size_t index = order_[next_++];
  const recording::FrameRecord& record = file_.record(index);
  frame.time = record.time;
  if (!record.problem.empty()) throw Error(ErrorCode::kCorruptInput, record.problem);
  frame.depth_unit = record.depth_unit;
  if (record.camera_to_world) {
    frame.has_pose = 1;
    std::copy(record.camera_to_world->begin(), record.camera_to_world->end(), frame.camera_to_world);
  }
  frame.color = read_color(index, frame);
  frame.depth = read(index, Stream::kDepth);
  frame.infrared = read(index, Stream::kInfrared);
  frame.confidence = read(index, Stream::kConfidence);
  if (read_masks_) frame.labels = read(index, Stream::kLabels);
  return KINORA_OK;
}

KinoraImage RecordingReader::read(std::size_t index, Stream stream) {
  const std::optional<recording::StoredPicture> picture = file_.read(index, stream);
  if (!picture) return {};
  const PictureShape shape = recording::shape_of(file_.description(), stream);
  std::vector<std::byte>& pixels = pixels_[static_cast<std::size_t>(stream)];
  pixels = file_.decode(index, stream, shape, picture->bytes);
  return view_of(shape, pixels.data());
}

KinoraImage RecordingReader::read_color(std::size_t index, KinoraFrame& frame) {
  std::optional<recording::StoredPicture> picture = file_.read(index, Stream::kColor);
  if (!picture) return {};
  if (picture->codec != recording::kMjpegCodec) {
    const PictureShape shape = recording::shape_of(file_.description(), Stream::kColor);
    std::vector<std::byte>& pixels = pixels_[static_cast<std::size_t>(Stream::kColor)];
    pixels = file_.decode(index, Stream::kColor, shape, picture->bytes);
    return view_of(shape, pixels.data());
  }
  encoded_color_ = std::move(picture->bytes);
  color_ = decode_color(encoded_color_, name_ + ": frame " + std::to_string(index));
  if (frame.struct_size >= sizeof(KinoraFrame)) {
    frame.color_jpeg = encoded_color_.data();
    frame.color_jpeg_bytes = encoded_color_.size();
  }
  return view_of({color_.width(), color_.height(), PixelLayout::kRgb8}, color_.data());
}

void RecordingReader::seek(std::int64_t index) { next_ = checked_seek(index, file_.frame_count()); }

bool RecordingReader::fill_sound(KinoraSound& sound) const {
  const container::Track* const track = file_.sound_track();
  if (track == nullptr) return false;
  sound::fill(sound, *track);
  return true;
}

bool RecordingReader::next_sound(KinoraSoundPacket& packet) {
  while (next_sound_ < file_.sound_packet_count()) {
    try {
      sound_packet_ = file_.read_sound(next_sound_++);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCorruptInput) throw;
      continue;
    }
    if (sound_packet_.bytes.empty()) continue;
    sound::fill(packet, sound_packet_, file_.description().start_time);
    return true;
  }
  return false;
}

} // namespace kinora::formats
