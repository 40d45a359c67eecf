// A factor of light for each colour, as exposure and white balance change pictures.
#pragma once

#include <array>

#include "core/image.h"

namespace kinora {

/// Factors of linear light: red, green, blue.
struct ColorGain {
  std::array<float, 3> factors{1, 1, 1};

  ColorGain inverse() const { return {{1 / factors[0], 1 / factors[1], 1 / factors[2]}}; }
  bool operator==(const ColorGain&) const = default;
};

/// sRGB values after a gain. Immutable, thread-safe.
class GainTables {
public:
  /// A value that may be saturated stays at least what it is: how bright it really was nobody knows.
  explicit GainTables(const ColorGain& gain);

  std::uint8_t operator()(int channel, std::uint8_t value) const {
    return tables_[static_cast<std::size_t>(channel)][value];
  }
  std::array<std::uint8_t, 3> operator()(const std::array<std::uint8_t, 3>& rgb) const {
    return {tables_[0][rgb[0]], tables_[1][rgb[1]], tables_[2][rgb[2]]};
  }
  /// Of a picture with 3 channels, or 4 whose alpha is straight and stays.
  void apply_to(ColorImage& picture) const;

  static constexpr int kSaturated = 250; ///< values from here on

private:
  std::array<std::array<std::uint8_t, 256>, 3> tables_;
};

} // namespace kinora
