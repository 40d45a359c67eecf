#include "video_pair/hue_depth.h"

#include <algorithm>
#include <cmath>

namespace kinora::formats {
namespace {

constexpr int kMinValue = 64;          ///< of 255
constexpr double kMinSaturation = 0.5; ///< video codecs blur colours at the borders

/// 0 to 1; negative: none.
double hue_of(const std::uint8_t* rgb) {
  const int r = rgb[0];
  const int g = rgb[1];
  const int b = rgb[2];
  const int largest = std::max({r, g, b});
  const int range = largest - std::min({r, g, b});
  if (largest < kMinValue || range < kMinSaturation * largest) return -1;
  double sixth = 0;
  if (largest == r)
    sixth = static_cast<double>(g - b) / range;
  else if (largest == g)
    sixth = 2 + static_cast<double>(b - r) / range;
  else
    sixth = 4 + static_cast<double>(r - g) / range;
  return sixth < 0 ? (sixth + 6) / 6 : sixth / 6;
}

} // namespace

DepthImage16 depth_of_hue(const ColorImage& image, const HueRange& range) {
  DepthImage16 depth(image.width(), image.height());
  for (std::size_t i = 0; i < depth.pixel_count(); ++i) {
    const double hue = hue_of(image.data() + 3 * i);
    if (hue < 0) continue;
    const double units = std::round((range.near + hue * (range.far - range.near)) / kHueDepthUnit);
    depth.data()[i] = static_cast<std::uint16_t>(std::clamp(units, 0.0, 65535.0));
  }
  return depth;
}

} // namespace kinora::formats
