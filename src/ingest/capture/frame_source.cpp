#include "ingest/capture/frame_source.h"

#include <fmt/format.h>

#include "core/error.h"
#include "ingest/depth/depth_cleaning.h"
#include "ingest/frame/label_borders.h"

namespace kinora::ingest {
namespace {

Intrinsics intrinsics_of(const KinoraCamera& camera) {
  return {camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy};
}

template <class T> Image<T> copy_of(const KinoraImage& image) {
  Image<T> copy(image.width, image.height, image.channels);
  const std::size_t row_values = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.channels);
  for (int v = 0; v < image.height; ++v)
    std::memcpy(copy.pixel(0, v), static_cast<const std::byte*>(image.data) + image.row_bytes * v,
                row_values * sizeof(T));
  return copy;
}

/// Metres, 0 where nothing is measured or where the plugin has no confidence in it.
DepthImage metres_of(const KinoraFrame& frame, double max_depth) {
  const auto units = copy_of<std::uint16_t>(frame.depth);
  const auto confidence = frame.confidence.data != nullptr ? copy_of<std::uint8_t>(frame.confidence) : LabelImage();
  DepthImage depth(units.width(), units.height());
  for (std::size_t i = 0; i < depth.pixel_count(); ++i) {
    const double metres = units.data()[i] * frame.depth_unit;
    const bool believed = confidence.empty() || confidence.data()[i] > 0;
    depth.data()[i] = believed && metres <= max_depth ? static_cast<float>(metres) : 0.0F;
  }
  return depth;
}

bool has_measurement(const DepthImage& depth) {
  const auto values = depth.values();
  return std::any_of(values.begin(), values.end(), [](float z) { return z > 0; });
}

template <class T> bool is_zero_everywhere(const KinoraImage& image) {
  const auto copy = copy_of<T>(image);
  const auto values = copy.values();
  return std::all_of(values.begin(), values.end(), [](T value) { return value == 0; });
}

/// Of a frame in which nothing counts as measured.
std::string why_unmeasured(const KinoraFrame& frame, double max_depth) {
  if (is_zero_everywhere<std::uint16_t>(frame.depth)) return "the depth image holds no measurement";
  if (frame.confidence.data != nullptr && is_zero_everywhere<std::uint8_t>(frame.confidence))
    return "the confidence of every depth pixel is 0";
  return fmt::format(
      "nothing is measured within {} m; if the scene is nearer, the capture states a wrong unit of depth "
      "(depth_factor)",
      max_depth);
}

std::optional<Undistortion> undistortion_of(const KinoraCamera& camera) {
  const double* k = camera.distortion;
  const Distortion distortion{k[0], k[1], k[2], k[3], k[4]};
  if (distortion.is_zero()) return std::nullopt;
  return Undistortion(intrinsics_of(camera), distortion);
}

RegistrationGeometry registration_of(const KinoraCaptureInfo& info, const char* format) {
  RegistrationGeometry geometry{intrinsics_of(info.depth_camera), intrinsics_of(info.camera), SE3::Identity()};
  geometry.depth.validate(std::string(format) + ": the depth camera");
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(info.depth_to_color);
  geometry.depth_to_color = rigid_from_matrix(matrix, "the pose of the depth camera");
  return geometry;
}

} // namespace

FrameSource::FrameSource(host::FrameReader reader, const CaptureOptions& options)
    : reader_(std::move(reader)), range_(options.frames), use_masks_(options.use_masks),
      masks_on_edges_(options.masks_on_edges), max_depth_(options.max_depth), cleaning_(options.cleaning),
      position_(range_.begin), intrinsics_(intrinsics_of(reader_.info().camera)) {
  reader_.replay(options.device);
  intrinsics_.validate(reader_.format().name);
  const KinoraCaptureInfo& info = reader_.info();
  undistortion_ = undistortion_of(info.camera);
  if (options.registration) {
    use_registration(*options.registration);
    return;
  }
  if (info.has_depth_camera == 0) return;
  registration_ = registration_of(info, reader_.format().name);
  depth_undistortion_ = undistortion_of(info.depth_camera);
}

void FrameSource::use_registration(const RegistrationGeometry& given) {
  const auto fits = [this](const Intrinsics& k) {
    return k.width == intrinsics_.width && k.height == intrinsics_.height;
  };
  if (reader_.info().has_depth_camera != 0 || !fits(given.depth) || !fits(given.color)) {
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: this is not the capture whose depth camera is given", reader_.format().name));
  }
  given.depth.validate("the given depth camera");
  given.color.validate("the given colour camera");
  registration_ = given;
  depth_undistortion_ = undistortion_;
  intrinsics_ = given.color;
  color_to_pose_ = given.depth_to_color.inverse();
}

SourceResult FrameSource::next() {
  SourceResult result;
  std::optional<host::ReadFrame> read;
  while (position_ < reader_.info().frame_count && range_.contains(position_)) {
    reader_.seek(position_);
    read = reader_.next();
    if (!read) break;
    result.dropped += read->dropped_before;
    result.index = static_cast<int>(reader_.position() - 1);
    position_ = range_.at_or_after(result.index + 1);
    if (range_.contains(result.index)) break; // else a device has lost frames up to one between those of the range
    read.reset();
  }
  if (!read) {
    result.end = true;
    return result;
  }
  result.device_time = read->frame.time;
  result.problem = read->problem;
  if (result.problem.empty() && reader_.info().has_poses != 0 && read->frame.has_pose == 0)
    result.problem = "the frame has no camera pose, though others have one";
  if (!result.problem.empty()) return result;
  result.has_infrared = read->frame.infrared.data != nullptr;
  Frame frame = convert(read->frame);
  frame.index = result.index;
  if (masks_on_edges_) result.mask_was_laid = repair_borders(frame);
  if (has_measurement(frame.depth))
    result.frame = std::move(frame);
  else
    result.problem = why_unmeasured(read->frame, max_depth_);
  return result;
}

/// As the undistorted colour camera sees it.
DepthImage FrameSource::depth_of(const KinoraFrame& given) const {
  DepthImage depth = metres_of(given, max_depth_);
  const std::optional<Undistortion>& undistortion = registration_ ? depth_undistortion_ : undistortion_;
  if (undistortion) depth = undistortion->depth(depth);
  return registration_ ? register_depth(depth, *registration_) : depth;
}

Frame FrameSource::convert(const KinoraFrame& given) const {
  Frame frame;
  frame.time = given.time - reader_.info().start_time;
  frame.camera.intrinsics = intrinsics_;
  if (reader_.info().has_poses != 0) {
    const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> pose(given.camera_to_world);
    frame.camera.camera_to_world = rigid_from_matrix(pose, "the camera pose") * color_to_pose_;
  }
  frame.color = copy_of<std::uint8_t>(given.color);
  frame.depth = depth_of(given);
  if (use_masks_ && given.labels.data != nullptr) frame.labels = copy_of<std::uint8_t>(given.labels);
  if (undistortion_) {
    frame.color = undistortion_->color(frame.color);
    if (frame.has_labels()) frame.labels = undistortion_->labels(frame.labels);
  }
  frame.clean_depth = clean_depth(frame.depth, intrinsics_, cleaning_);
  return frame;
}

} // namespace kinora::ingest
