// Between sRGB and linear light. Source: IEC 61966-2-1.
#pragma once

#include <cmath>

namespace kinora {

/// Both 0 to 1.
template <class Number> Number linear_light(Number srgb) {
  return srgb <= Number(0.04045) ? srgb / Number(12.92) : std::pow((srgb + Number(0.055)) / Number(1.055), Number(2.4));
}

/// The other way; both 0 to 1.
template <class Number> Number srgb_of_linear(Number light) {
  return light <= Number(0.0031308) ? light * Number(12.92)
                                    : Number(1.055) * std::pow(light, 1 / Number(2.4)) - Number(0.055);
}

} // namespace kinora
