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

struct Rounding {
  double steps_per_rms; ///< the root mean square of the values is so many steps, or less than twice as many; 0: all 0
  double up_from = 0.5; ///< what is left of a step that counts as one more: above a half, small values cost less
  bool anew = false;    ///< also what is a multiple of a power of two already
};

/// Rounds to a multiple of a power of two that depends on the values alone; where some values are 1000 times as large
/// as the root mean square, by larger steps than `rounding` says. |error| ≤ step · up_from. Values that already are
/// 16-bit multiples of one stay as they are, unless they are to be rounded anew: quantise(dequantise(q)) = q.
/// Thread-safe. Throws Error(kFailure) if a value is not
/// finite or larger than 2^54.
QuantisedLevel quantise(std::span<const float> values, const Rounding& rounding);

/// Exact in float for every exponent within the limits.
float dequantise(std::int16_t value, int exponent);

} // namespace kinora::clip
