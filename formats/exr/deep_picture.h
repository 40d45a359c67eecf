// The layers of a picture as an OpenEXR deep image.
// Source: Kainz, "Interpreting OpenEXR Deep Pixels" (2013).
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <OpenEXR/ImfHeader.h>

#include "kinora/plugin.h"

namespace kinora::formats {

/// A file with a sample for each layer that a pixel shows, the nearest first: R G B A (half, linear light, multiplied
/// by alpha), Z (float, metres along the optical axis) and id (unsigned, the layer's label). `header`: its size and
/// attributes are kept. Where a layer has no depth, at its thin rims, that of pixels beside it is taken; what has none
/// there either is left out. Throws Error(kUsage) if a layer has another size. `name`: for errors.
std::vector<std::byte> deep_bytes(std::span<const KinoraPicture> layers, const Imf::Header& header,
                                  const std::string& name);

} // namespace kinora::formats
