// Where a layer may be in a picture: on its own pixels, or hidden behind those of others.
// Source: Danielsson, "Euclidean Distance Mapping", CGIP 14, 1980.
#pragma once

#include <cstdint>

#include "core/image.h"

namespace kinora::tracking {

/// Offsets in pixels (x, y) from each pixel to the nearest one that is not zero in `allowed`; zero there. Wrong by less
/// than a pixel at most. Without any such pixel all offsets are as long as the picture is large.
Image<std::int16_t> offsets_to_silhouette(const LabelImage& allowed);

} // namespace kinora::tracking
