// Pixels on both sides of a layer's rim in one frame: what tells where its silhouette is.
#pragma once

#include <cstdint>
#include <vector>

#include "fields/model/field.h"
#include "fields/sampling/layer_observations.h"

namespace kinora::fields {

struct ContourPixel {
  std::uint32_t pixel; ///< index into PixelStore::pixels()
  float depth;         ///< metres: of the layer's surface at the rim
};

struct ContourPixels {
  std::vector<ContourPixel> inside;  ///< own pixels, measured or guessed, beside one that sees past the layer
  std::vector<ContourPixel> outside; ///< pixels of others that see past it, two pixels from an own one at most
};

/// A pixel sees past the layer where nothing is up to a band behind the layer's surface beside it. In the order of the
/// frame's pixels.
ContourPixels contour_pixels(const LayerObservations& layer, const StoredFrame& frame, const FieldConfig& config);

} // namespace kinora::fields
