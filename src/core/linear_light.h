// From sRGB to linear light. Source: IEC 61966-2-1.
#pragma once

#include <cmath>

namespace kinora {

/// Both 0 to 1.
template <class Number> Number linear_light(Number srgb) {
  return srgb <= Number(0.04045) ? srgb / Number(12.92) : std::pow((srgb + Number(0.055)) / Number(1.055), Number(2.4));
}

} // namespace kinora
