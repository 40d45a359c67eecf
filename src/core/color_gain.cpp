#include "core/color_gain.h"

#include <algorithm>
#include <cmath>

#include "core/linear_light.h"

namespace kinora {

GainTables::GainTables(const ColorGain& gain) {
  for (std::size_t c = 0; c < 3; ++c) {
    for (int value = 0; value < 256; ++value) {
      const float light = gain.factors[c] * linear_light(static_cast<float>(value) / 255);
      const int after = static_cast<int>(std::lround(255 * srgb_of_linear(std::clamp(light, 0.0F, 1.0F))));
      tables_[c][static_cast<std::size_t>(value)] =
          static_cast<std::uint8_t>(value >= kSaturated ? std::max(value, after) : after);
    }
  }
}

void GainTables::apply_to(ColorImage& picture) const {
  for (int v = 0; v < picture.height(); ++v) {
    for (int u = 0; u < picture.width(); ++u) {
      std::uint8_t* rgb = picture.pixel(u, v);
      for (std::size_t c = 0; c < 3; ++c) rgb[c] = tables_[c][rgb[c]];
    }
  }
}

} // namespace kinora
