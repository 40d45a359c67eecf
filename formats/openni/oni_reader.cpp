#include "openni/oni_reader.h"

#include <algorithm>

#include "common/frame_pairs.h"
#include "core/error.h"
#include "openni/nominal_camera.h"
#include "openni/oni_pictures.h"

namespace kinora::formats {
namespace {

constexpr double kMaxTimeDifference = 0.02;

/// Changes right and left over.
template <class T> void mirror(Image<T>& image) {
  for (int v = 0; v < image.height(); ++v)
    for (int left = 0, right = image.width() - 1; left < right; ++left, --right)
      std::swap_ranges(image.pixel(left, v), image.pixel(left, v) + image.channels(), image.pixel(right, v));
}

} // namespace

OniReader::OniReader(const std::filesystem::path& path, double focal_length) : file_(path) {
  OniLog log = read_oni_log(file_);
  if (!log.color || !log.depth || log.color->pictures.empty() || log.depth->pictures.empty())
    throw Error(ErrorCode::kCorruptInput, file_.name() + ": a .oni file, but without pictures of colour and of depth" +
                                              (log.problem.empty() ? "" : " (" + log.problem + ")"));
  if (!log.problem.empty()) warnings_.push_back(log.problem + "; what stands before is read");
  color_stream_ = *std::move(log.color);
  depth_stream_ = *std::move(log.depth);
  color_camera_ = camera_of_stream(color_stream_, focal_length);
  const bool told = depth_stream_.horizontal_view > 0;
  depth_camera_ = camera_of_stream(
      depth_stream_, told || focal_length == 0 ? 0 : focal_length * depth_stream_.width / color_stream_.width);
  if (focal_length == 0 && color_stream_.horizontal_view <= 0) warnings_.push_back(file_.name() + ": " + kUnknownView);
  if (!is_same_camera(depth_camera_, color_camera_))
    warnings_.push_back(file_.name() + ": depth and colour see differently far; it is not known how the two cameras "
                                       "stand, and they are taken to stand in one place");
  pair_pictures();
  warning_table_.set(warnings_);
}

Intrinsics OniReader::camera_of_stream(const OniStream& stream, double focal_length) const {
  const OniSize size = size_of(stream, file_.name());
  Intrinsics camera = nominal_camera(stream.cropped ? std::max(stream.width, 1) : size.width,
                                     stream.cropped ? std::max(stream.height, 1) : size.height, stream.horizontal_view,
                                     stream.vertical_view, focal_length);
  camera.width = size.width;
  camera.height = size.height;
  if (!stream.cropped) return camera;
  camera.cx -= stream.crop_x;
  camera.cy -= stream.crop_y;
  if (stream.mirrored) camera.cx = size.width - 1 - camera.cx;
  return camera;
}

void OniReader::pair_pictures() {
  std::vector<OniPicture>& colors = color_stream_.pictures;
  std::vector<OniPicture>& depths = depth_stream_.pictures;
  const bool color_moved = put_in_order(colors);
  const bool depth_moved = put_in_order(depths);
  if (color_moved || depth_moved)
    warnings_.push_back(file_.name() + ": pictures are out of order; frames are taken in order of time");
  for (const auto& [color, depth] : pair_by_time(times_of(colors), times_of(depths), kMaxTimeDifference))
    frames_.push_back({colors[color].time, colors[color], depths[depth]});
  if (frames_.empty())
    throw Error(ErrorCode::kCorruptInput, file_.name() + ": no colour picture has a depth picture within 20 ms");
  if (frames_.size() < colors.size())
    warnings_.push_back(file_.name() + ": " + std::to_string(colors.size() - frames_.size()) +
                        " colour pictures have no depth picture within 20 ms and are left out");
  frames_per_second_ = median_rate(times_of(frames_));
}

void OniReader::fill_info(KinoraCaptureInfo& info) const {
  info.frame_count = static_cast<std::int64_t>(frames_.size());
  info.start_time = frames_.front().time;
  info.frames_per_second = frames_per_second_;
  info.camera = camera_of(color_camera_, {});
  warning_table_.fill(info);
  if (!is_same_camera(depth_camera_, color_camera_))
    set_depth_camera(info, camera_of(depth_camera_, {}), SE3::Identity());
}

void OniReader::read_color(const OniPicture& picture, KinoraFrame& frame) {
  color_bytes_ = file_.read(picture.offset, picture.bytes);
  color_ = oni_color(color_bytes_, color_stream_, file_.name() + ", colour " + std::to_string(frame.index));
  if (color_stream_.mirrored) mirror(color_);
  frame.color = view_of(color_, KINORA_PIXEL_U8);
  const bool as_it_is = is_jpeg_stream(color_stream_) && !color_stream_.mirrored;
  if (!as_it_is || frame.struct_size < sizeof(KinoraFrame)) return;
  frame.color_jpeg = color_bytes_.data();
  frame.color_jpeg_bytes = color_bytes_.size();
}

KinoraStatus OniReader::next(KinoraFrame& frame) {
  if (next_ >= frames_.size()) return KINORA_END;
  frame.index = static_cast<std::int64_t>(next_);
  const Frame& entry = frames_[next_++];
  frame.time = entry.time;
  read_color(entry.color, frame);
  depth_ = oni_depth(file_.read(entry.depth.offset, entry.depth.bytes), depth_stream_,
                     file_.name() + ", depth " + std::to_string(frame.index));
  if (depth_stream_.mirrored) mirror(depth_);
  frame.depth = view_of(depth_, KINORA_PIXEL_U16);
  frame.depth_unit = depth_stream_.pixels == OniPixels::kDepthTenthMillimetres ? 0.0001 : 0.001;
  return KINORA_OK;
}

void OniReader::seek(std::int64_t index) { next_ = checked_seek(index, frames_.size()); }

} // namespace kinora::formats
