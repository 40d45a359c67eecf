// Pixels that measure a deforming layer, carried into its canonical space once and kept: poses of stored frames do not
// change. Near the surface that it measures a ray becomes two halves of parabolas there.
#pragma once

#include <array>
#include <cstdint>

#include "core/sensor_noise.h"
#include "fields/model/field.h"
#include "fields/network/vector_features.h"
#include "fields/sampling/layer_observations.h"
#include "fields/sampling/occupancy.h"

namespace kinora::fields {

struct WarpedPixel {
  std::uint32_t pixel; ///< index into PixelStore::pixels()
  FieldRay ray;        ///< its ray about the measured depth, relative to the field's box
  /// What the ray leaves its straight line by, for each squared metre of depth before and behind the measured surface.
  std::array<std::array<float, 3>, 2> curvatures{};
  PackedRotation rotation{};
};

/// The layer's own pixels with measured (also doubtful) depth, their rays as they are about that depth. Pixels of lost
/// frames and those that no node carries are left out. `noise`: LossWeights::noise.
LargeBuffer<WarpedPixel> warp_measured_pixels(const LayerObservations& layer, const FieldConfig& config,
                                              SensorNoise noise = {});

} // namespace kinora::fields
