#include "clip/coding/level_quantiser.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace kinora::clip {

namespace {

constexpr double kLargestInteger = std::numeric_limits<std::int16_t>::max();

struct Spread {
  double largest = 0;
  double rms = 0;
  int finest_bit = kMaxExponent; // the largest e for which all values are multiples of 2^e
};

// Exponent of the lowest bit of a float that is not zero.
int lowest_bit(float value) {
  constexpr int kMantissaBits = 24;
  int exponent = 0;
  const auto mantissa = static_cast<std::uint32_t>(std::ldexp(std::frexp(std::abs(value), &exponent), kMantissaBits));
  return exponent - kMantissaBits + std::countr_zero(mantissa);
}

Spread spread_of(std::span<const float> values) {
  Spread spread;
  double sum = 0;
  for (const float value : values) {
    if (!std::isfinite(value) || std::abs(value) > std::ldexp(1.0, kMaxExponent + 14)) {
      throw Error(ErrorCode::kFailure,
                  "a field holds parameters that are not finite; it cannot be stored, train it anew");
    }
    sum += static_cast<double>(value) * value;
    spread.largest = std::max(spread.largest, static_cast<double>(std::abs(value)));
    if (value != 0) spread.finest_bit = std::min(spread.finest_bit, lowest_bit(value));
  }
  spread.rms = std::sqrt(sum / static_cast<double>(values.size()));
  return spread;
}

int choose_exponent(const Spread& spread, const Rounding& rounding) {
  const auto fits = [&](int exponent) { return spread.largest <= std::ldexp(kLargestInteger, exponent); };
  // Values that were quantised before, or while they were trained, lie on a coarse lattice.
  const int lattice = spread.finest_bit;
  if (!rounding.anew && lattice >= kMinExponent && fits(lattice)) return lattice;
  int exponent = std::clamp(std::ilogb(spread.rms / rounding.steps_per_rms), kMinExponent, kMaxExponent);
  while (!fits(exponent)) ++exponent;
  return exponent;
}

// Common factors of two go to the exponent, so that the integers alone tell the lattice.
void normalise(QuantisedLevel& level) {
  unsigned bits = 0;
  for (const std::int16_t value : level.values) bits |= static_cast<std::uint16_t>(value);
  if (bits == 0) {
    level.exponent = 0;
    return;
  }
  const int shift = std::min(std::countr_zero(bits), kMaxExponent - level.exponent);
  for (std::int16_t& value : level.values) value = static_cast<std::int16_t>(value / (1 << shift));
  level.exponent += shift;
}

} // namespace

QuantisedLevel quantise(std::span<const float> values, const Rounding& rounding) {
  QuantisedLevel level;
  level.values.resize(values.size());
  const Spread spread = values.empty() ? Spread{} : spread_of(values);
  if (spread.largest == 0 || rounding.steps_per_rms == 0) return level;
  level.exponent = choose_exponent(spread, rounding);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double steps = std::ldexp(static_cast<double>(values[i]), -level.exponent);
    const double size = std::floor(std::abs(steps) + 1 - rounding.up_from);
    level.values[i] = static_cast<std::int16_t>(std::copysign(std::min(size, kLargestInteger), steps));
  }
  normalise(level);
  return level;
}

float dequantise(std::int16_t value, int exponent) { return std::ldexp(static_cast<float>(value), exponent); }

} // namespace kinora::clip
