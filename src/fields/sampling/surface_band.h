// What a measured depth tells: within which distance of it the surface is expected, and where nothing is.
#pragma once

#include <algorithm>

#include "core/sensor_noise.h"
#include "fields/model/field.h"
#include "fields/sampling/pixel_store.h"

namespace kinora::fields {

/// Metres: beyond all that is modelled.
inline constexpr float kFarthest = 1e6F;

/// Metres: the least half width of the band around a measured depth: four cells of the finest level, and room for a few
/// centimetres of pose error where the layer is large.
inline float min_band(const FieldConfig& config) {
  return static_cast<float>(std::max(4 * config.cell_size(), std::min(0.02, 0.02 * config.box.side)));
}

/// Metres: half width of the band around a measured depth, three standard deviations or the least.
inline float surface_band(const FieldConfig& config, float depth, SensorNoise noise = {}) {
  return std::max(noise.three_sigma(depth), min_band(config));
}

/// Metres: up to where a pixel shows that a layer which is not its own is not there. A guessed depth keeps twice the
/// distance from its surface. Without any depth, one that is labelled as somebody else's tells nothing; but what is
/// labelled background and is measured nowhere around is behind everything: its surface is guessed from afar at best.
inline float free_space_until(const StoredPixel& pixel, SensorNoise noise = {}) {
  const float depth = pixel.depth.metres();
  if (pixel.depth.is_measured()) return depth - noise.three_sigma(depth);
  if (pixel.depth.is_guessed() && !pixel.depth.is_extended()) return depth - 2 * noise.three_sigma(depth);
  return pixel.label == 0 ? kFarthest : 0;
}

} // namespace kinora::fields
