// What a pixel's ray meets in a layer.
#pragma once

#include <array>
#include <cstdint>

#include "fields/network/vector_features.h"

namespace kinora::fields {

struct Surface {
  float depth; ///< metres
  float opacity;
  std::uint32_t layer;
  std::array<float, 3> position;   ///< relative to the field's box, where the light is taken away in the mean
  std::array<float, 3> sigma;      ///< its standard deviation along the ray
  Rotation rotation = kNoRotation; ///< of the layer there

  /// Nearer; of layers that meet at one depth, whichever was marched to first, the first.
  bool operator<(const Surface& farther) const {
    return depth < farther.depth || (depth == farther.depth && layer < farther.layer);
  }
};

} // namespace kinora::fields
