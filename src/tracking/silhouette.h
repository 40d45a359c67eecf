// Where a layer may be in a picture: on its own pixels, or hidden behind those of others.
// Source: Meijster, Roerdink and Hesselink, "A General Algorithm for Computing Distance Transforms in Linear Time",
// 2000.
#pragma once

#include <cstdint>

#include "core/image.h"

namespace kinora::tracking {

/// Offsets in pixels (x, y) from each pixel to the nearest one that is not zero in `allowed`; zero there. Without any
/// such pixel all offsets are longer than the picture is large. Thread-safe.
Image<std::int16_t> offsets_to_silhouette(const LabelImage& allowed);

} // namespace kinora::tracking
