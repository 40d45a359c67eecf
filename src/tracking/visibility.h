// When a view says something of a point of a model: thresholds that all of tracking shares.
#pragma once

#include "core/camera.h"
#include "core/free_space.h"

namespace kinora::tracking {

/// What is measured nearer by more hides a point of a model, farther by more the point violates free space, and between
/// them what is measured may be the point: pose and model are off by some centimetres, or the sensor is.
inline constexpr DepthMargin kPoseMargin{0.03, 3};

} // namespace kinora::tracking
