// What readers of captures hand out, in the interface's form.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "common/boundary.h"
#include "core/camera.h"
#include "core/image.h"

namespace kinora::formats {

/// Points to the image's pixels; no image if it is empty.
template <class T> KinoraImage view_of(const Image<T>& image, KinoraPixelType type) {
  KinoraImage view{};
  if (image.empty()) return view;
  view.width = image.width();
  view.height = image.height();
  view.channels = image.channels();
  view.pixel_type = type;
  view.row_bytes = sizeof(T) * static_cast<std::size_t>(image.width()) * static_cast<std::size_t>(image.channels());
  view.data = image.data();
  return view;
}

inline KinoraCamera camera_of(const Intrinsics& k, const Distortion& d) {
  return {k.width, k.height, k.fx, k.fy, k.cx, k.cy, {d.k1, d.k2, d.p1, d.p2, d.k3}, {}};
}

/// Row by row, as the interface has matrices.
inline void store_transform(const SE3& transform, double* to) {
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> matrix = transform.matrix();
  std::copy(matrix.data(), matrix.data() + matrix.size(), to);
}

inline void set_pose(KinoraFrame& frame, const SE3& camera_to_world) {
  store_transform(camera_to_world, frame.camera_to_world);
  frame.has_pose = 1;
}

/// Throws Error(kFailure) if the host was made before there were depth cameras.
inline void set_depth_camera(KinoraCaptureInfo& info, const KinoraCamera& camera, const SE3& depth_to_color) {
  if (info.struct_size < sizeof(KinoraCaptureInfo))
    throw Error(ErrorCode::kFailure, "the host is too old for depth that is not registered to colour");
  info.has_depth_camera = 1;
  info.depth_camera = camera;
  store_transform(depth_to_color, info.depth_to_color);
}

/// Sentences about a whole capture, as the interface takes them. They must outlive it.
class WarningTable {
public:
  void set(const std::vector<std::string>& warnings) {
    table_.clear();
    for (const std::string& warning : warnings) table_.push_back(warning.c_str());
  }
  void fill(KinoraCaptureInfo& info) const {
    info.warnings = table_.data();
    info.warning_count = table_.size();
  }

private:
  std::vector<const char*> table_;
};

/// Throws Error(kUsage) unless a capture of `count` frames can go to frame `index`.
inline std::size_t checked_seek(std::int64_t index, std::size_t count) {
  if (index < 0 || static_cast<std::size_t>(index) > count)
    throw Error(ErrorCode::kUsage, "frame " + std::to_string(index) + " does not exist; the capture has " +
                                       std::to_string(count) + " frames");
  return static_cast<std::size_t>(index);
}

} // namespace kinora::formats
