// What a measured depth tells: within which distance of it the surface is expected, and where nothing is.
#pragma once

#include <algorithm>

#include "fields/field.h"
#include "fields/pixel_store.h"
#include "ingest/sensor_noise.h"

namespace kinora::fields {

/// Metres: beyond all that is modelled.
inline constexpr float kFarthest = 1e6F;

/// Metres: three standard deviations of a measurement at a depth, where a layer's are `noise` times those of the
/// sensor (LossWeights::noise).
inline float three_sigma(float depth, float noise = 1) {
  return noise * static_cast<float>(3.0 * ingest::depth_sigma(depth));
}

/// Metres: the least half width of the band around a measured depth: four cells of the finest level, and room for a few
/// centimetres of pose error where the layer is large.
inline float least_band(const FieldConfig& config) {
  return static_cast<float>(std::max(4 * config.cell_size(), std::min(0.02, 0.02 * config.box.side)));
}

/// Metres: half width of the band around a measured depth, three standard deviations or the least.
inline float surface_band(const FieldConfig& config, float depth, float noise = 1) {
  return std::max(three_sigma(depth, noise), least_band(config));
}

/// Metres: up to where a pixel shows that a layer which is not its own is not there. A guessed depth keeps twice the
/// distance from its surface. Without any depth, one that is labelled as somebody else's tells nothing; but what is
/// labelled background and is measured nowhere around is taken to be out of the sensor's reach, behind everything.
inline float empty_until(const StoredPixel& pixel, float noise = 1) {
  const float depth = pixel.depth.metres();
  if (pixel.depth.is_measured()) return depth - three_sigma(depth, noise);
  if (pixel.depth.is_guessed()) return depth - 2 * three_sigma(depth, noise);
  return pixel.label == 0 ? kFarthest : 0;
}

} // namespace kinora::fields
