// Pictures as JPEG.
#pragma once

#include <cstddef>
#include <vector>

#include "core/image.h"

namespace kinora {

/// 3 channels sRGB; `quality` 1–100, from 90 on without halving the resolution of colour. The same picture gives the
/// same bytes. Throws Error(kFailure).
std::vector<std::byte> encode_jpeg(const ColorImage& image, int quality);

} // namespace kinora
