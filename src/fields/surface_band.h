// Within which distance of a measured depth the surface is expected.
#pragma once

#include <algorithm>

#include "fields/field.h"
#include "ingest/sensor_noise.h"

namespace kinora::fields {

/// Metres: three standard deviations of the sensor at a depth.
inline float three_sigma(float depth) { return static_cast<float>(3.0 * ingest::depth_sigma(depth)); }

/// Half width in metres of the band around a measured depth: three standard deviations of the sensor, at least four
/// cells of the finest level, and room for a few centimetres of pose error where the layer is large.
inline float surface_band(const FieldConfig& config, float depth) {
  const double pose_error = std::min(0.02, 0.02 * config.box.side);
  return std::max({three_sigma(depth), static_cast<float>(4 * config.cell_size()), static_cast<float>(pose_error)});
}

} // namespace kinora::fields
