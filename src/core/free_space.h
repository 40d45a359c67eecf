// What a measured depth says of a point on the same ray: that it is hidden, may be what was measured, or violates free
// space.
// Source: Ganapathi, Plagemann, Koller, Thrun, "Real-Time Human Pose Tracking from Range Data", ECCV 2012 (a model may
// not stand in space that the camera sees to be free).
#pragma once

#include <algorithm>

#include "core/sensor_noise.h"

namespace kinora {

/// By how much a point may lie before or behind what is measured on its ray and be taken to be at that depth.
struct DepthMargin {
  double metres; ///< at least: what the point's own place is uncertain by
  double sigmas; ///< of the sensor, at the point

  /// Metres, for a point at depth z.
  constexpr double at(double z) const { return std::max(metres, sigmas * kSensorNoise.sigma(z)); }
};

// `z`: the point's depth, `measured`: at its pixel, 0 if nothing is. Both in metres along the optical axis. In lanes:
// free_space_simd.h.

/// Something measured stands before the point.
constexpr bool is_occluded(double z, double measured, const DepthMargin& margin) {
  return measured > 0 && measured < z - margin.at(z);
}

/// The camera sees past where the point should be. Where nothing is measured that is not known.
constexpr bool violates_free_space(double z, double measured, const DepthMargin& margin) {
  return measured > z + margin.at(z);
}

} // namespace kinora
