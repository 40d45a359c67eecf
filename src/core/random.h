// Counter-based random numbers: the same key gives the same number on every thread and in every order.
#pragma once

#include <cstdint>

namespace kinora {

/// A bijective mix of 64 bits (the finaliser of SplitMix64; Steele et al., OOPSLA 2014).
constexpr std::uint64_t mix64(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

/// A stream of numbers that depends on (seed, stream) alone. Cheap to make: one per work item.
class Random {
public:
  constexpr explicit Random(std::uint64_t seed, std::uint64_t stream = 0) : state_(mix64(seed) ^ mix64(~stream)) {}

  constexpr std::uint64_t next() { return mix64(state_++); }
  /// Uniform in [0, 1).
  constexpr float uniform() { return static_cast<float>(next() >> 40) * 0x1p-24F; }
  constexpr double uniform_double() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  /// Uniform in [0, bound); bound > 0. (Lemire's multiplication; the bias is below 2⁻³².)
  constexpr std::uint32_t below(std::uint32_t bound) {
    return static_cast<std::uint32_t>(((next() >> 32) * bound) >> 32);
  }
  /// Standard normal (Box–Muller, one of the pair).
  double normal();

private:
  std::uint64_t state_;
};

} // namespace kinora
