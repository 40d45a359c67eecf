// When a view says something of a point of a model: thresholds that all of tracking shares.
#pragma once

#include "core/camera.h"
#include "core/free_space.h"

namespace kinora::tracking {

/// Metres along the optical axis: nothing nearer to a camera is fused, or compared with what it shows.
inline constexpr double kNearestDepth = 0.05;

/// Cosine between a surface's normal and the way to the camera: a surface that is seen flatter (from 80° on) does not
/// show.
inline constexpr double kFacingCosine = 0.17;

/// Cosine between two normals (45°): beyond, they are not of the same surface.
inline constexpr double kNormalCosine = 0.7;

/// Whether a place in the picture rounds to a pixel of it, with room for rounding errors.
inline bool is_in_picture(double u, double v, const Intrinsics& camera) {
  return u > -0.49 && v > -0.49 && u < camera.width - 0.51 && v < camera.height - 0.51;
}

/// What is measured nearer by more hides a point of a model, farther by more the point violates free space, and between
/// them what is measured may be the point: pose and model are off by some centimetres, or the sensor is.
inline constexpr DepthMargin kPoseMargin{0.03, 3};

} // namespace kinora::tracking
