// Carries depth from a depth camera of its own into the colour camera.
#pragma once

#include "core/camera.h"
#include "core/image.h"

namespace kinora::ingest {

/// Where the depth camera stands and what it sees. Both cameras are free of distortion.
struct RegistrationGeometry {
  Intrinsics depth;
  Intrinsics color;
  SE3 depth_to_color = SE3::Identity(); ///< carries points of the depth camera to the colour camera
};

/// Depth (metres, 0 = none) as the colour camera would measure it. Neighbouring measurements that no jump separates
/// span small triangles, which are drawn with a z-buffer: the nearest surface wins, and a surface keeps no gaps where
/// colour has more pixels than depth. A measurement without such neighbours fills the one pixel it falls into. What
/// the depth camera did not see stays a hole. The same bits for any number of threads. Thread-safe.
/// Throws Error(kUsage) if `depth` does not have the size of its camera.
DepthImage register_depth(const DepthImage& depth, const RegistrationGeometry& geometry);

} // namespace kinora::ingest
