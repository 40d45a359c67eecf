// Table parameters as 16-bit integers times a power of two.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace kinora::clip {

/// value ≈ integer · 2^exponent.
struct QuantisedLevel {
  int exponent = 0;
  std::vector<std::int16_t> values;
};

inline constexpr int kMinExponent = -60;
inline constexpr int kMaxExponent = 40;
/// The root mean square of a level is at least this many steps (fewer only where a level holds values 1000 times its
/// root mean square), so that |error| ≤ step / 2 ≤ rms / (2 · kStepsPerRms): 1.8 % root mean square.
inline constexpr int kStepsPerRms = 16;

/// Rounds to the nearest multiple of a power of two that depends on the values alone. Values that already are such
/// multiples stay as they are: quantise(dequantise(q)) = q. Thread-safe.
/// Throws Error(kFailure) if a value is not finite or larger than 2^54.
QuantisedLevel quantise(std::span<const float> values);

/// Exact in float for every exponent within the limits.
float dequantise(std::int16_t value, int exponent);

} // namespace kinora::clip
