// Which colours a thing has: counted, and as a smoothed histogram.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace kinora::ingest {

/// Of colours: over 6 steps of brightness and 16 × 16 of colour difference (blue and red against grey).
struct ColorHistogram {
  static constexpr std::size_t kSteps = 16;
  static constexpr std::size_t kLights = 6;
  static std::size_t bin_of(const std::uint8_t* rgb);

  std::array<float, kLights * kSteps * kSteps> bins{};
};

/// How likely each colour is. Immutable, thread-safe.
class ColorModel {
public:
  /// Of a thing without colours.
  ColorModel() = default;

  /// Natural logarithm of how much likelier a colour is here than in `other`, within ±5.
  float log_ratio(const ColorModel& other, const std::uint8_t* rgb) const;
  /// Part that two models have in common, 0 to 1.
  double overlap(const ColorModel& other) const;

private:
  friend class ColorCounts;
  ColorHistogram likelihood_;
};

/// How often each colour was seen. Not thread-safe to fill.
class ColorCounts {
public:
  void add(const std::uint8_t* rgb) { counts_.bins[ColorHistogram::bin_of(rgb)] += 1; }
  void add(const ColorCounts& other);
  /// Share of the counts of a colour that is here and not in `other`. 1 if nobody has it.
  float share_against(const ColorCounts& other, const std::uint8_t* rgb) const;
  /// Every count is spread to the neighbouring bins, and the sum is 1.
  ColorModel model() const;

private:
  ColorHistogram counts_;
};

} // namespace kinora::ingest
