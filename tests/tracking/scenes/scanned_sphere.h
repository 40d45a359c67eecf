// A volume with something in it.
#pragma once

#include "synthetic_scene.h"
#include "tracking/tsdf/tsdf.h"

namespace kinora::tracking::testing {

/// The front of a sphere of 15 cm, relative to its centre, seen `views` times from 1 m.
inline TsdfVolume scanned_sphere(int views = 1) {
  const SE3 position(Eigen::Translation3d(0, 0, 1));
  const Shape shape{ShapeKind::kSphere, {0.15, 0, 0}, true};
  const ingest::Frame frame = render_frame(shape, position, SE3::Identity(), 0, {});
  TsdfVolume volume({0.006, 0.03, 64}, position.translation());
  LabelImage mask = frame.labels;
  for (std::uint8_t& value : mask.values()) value = value == 2 ? 1 : 0;
  for (int i = 0; i < views; ++i) {
    volume.integrate(fit_depth_planes(frame.depth, frame.camera.intrinsics, mask), Image<float>(),
                     frame.camera.intrinsics, SE3::Identity());
  }
  return volume;
}

} // namespace kinora::tracking::testing
