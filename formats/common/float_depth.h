// Depth that formats store as floats in metres, in the 16 bits of the plugin interface.
#pragma once

#include <cmath>
#include <cstdint>

namespace kinora::formats {

inline constexpr double kFloatDepthUnit = 0.00025; ///< metres per unit: up to 16 m

/// 0, no measurement, for what is not finite, not positive or too far.
inline std::uint16_t depth_units(double metres) {
  constexpr double kMax = 65535;
  const double units = std::round(metres / kFloatDepthUnit);
  return units > 0 && units <= kMax ? static_cast<std::uint16_t>(units) : std::uint16_t{0};
}

} // namespace kinora::formats
