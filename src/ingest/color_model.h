// Which colours a thing has, as a smoothed histogram.
#pragma once

#include <array>
#include <cstdint>

namespace kinora::ingest {

/// Counts over 6 steps of brightness and 16 × 16 of colour difference (blue and red against grey). Not thread-safe to
/// fill, thread-safe to ask.
class ColorModel {
public:
  void add(const std::uint8_t* rgb, float weight = 1) { counts_[bin_of(rgb)] += weight; }
  void add(const ColorModel& other);
  /// Spreads every count to the neighbouring bins and makes the sum 1. To be called once, after all `add`.
  void finish();
  bool empty() const;
  /// Share of the counted weight of a colour that is here and not in `other`; neither finished. 1 if nobody has it.
  float share_against(const ColorModel& other, const std::uint8_t* rgb) const;
  /// Natural logarithm of how much likelier a colour is here than in `other`, within ±5. Both finished.
  float log_ratio(const ColorModel& other, const std::uint8_t* rgb) const;
  /// Part that two finished models have in common, 0 to 1.
  double overlap(const ColorModel& other) const;

private:
  static constexpr std::size_t kSteps = 16;
  static constexpr std::size_t kLights = 6;
  static std::size_t bin_of(const std::uint8_t* rgb);

  std::array<float, kLights * kSteps * kSteps> counts_{};
};

} // namespace kinora::ingest
