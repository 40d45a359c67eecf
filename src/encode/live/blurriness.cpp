#include "encode/live/blurriness.h"

#include <algorithm>
#include <cmath>

namespace kinora::encode {
namespace {

constexpr int kReach = 5; ///< pixels to either side that a difference of means over nine looks at

/// Differences of neighbours along one direction, and what blurring takes from them.
struct Differences {
  double sum = 0;
  double lost = 0;

  /// `line`: luminance, `step` apart; at the pixel itself.
  void add(const float* line, std::ptrdiff_t step) {
    constexpr float kMean = 9;
    const float sharp = std::abs(line[0] - line[-step]);
    const float blurred = std::abs(line[(kReach - 1) * step] - line[-kReach * step]) / kMean;
    sum += sharp;
    lost += std::max(0.0F, sharp - blurred);
  }
  double blurriness() const { return sum > 0 ? (sum - lost) / sum : 1; }
};

Image<float> luminance_of(const ColorImage& color) {
  Image<float> out(color.width(), color.height());
  for (std::size_t i = 0; i < out.pixel_count(); ++i) {
    const std::uint8_t* rgb = color.data() + static_cast<std::size_t>(color.channels()) * i;
    out.data()[i] = 0.299F * rgb[0] + 0.587F * rgb[1] + 0.114F * rgb[2];
  }
  return out;
}

} // namespace

std::optional<double> blurriness(const ingest::Frame& frame) {
  constexpr std::size_t kFewest = 200; // pixels
  const LabelImage& labels = frame.labels;
  const bool is_labelled = std::ranges::any_of(labels.values(), [](std::uint8_t label) { return label != 0; });
  const Image<float> luminance = luminance_of(frame.color);
  Differences across;
  Differences down;
  std::size_t pixels = 0;
  for (int v = kReach; v < luminance.height() - kReach; ++v) {
    for (int u = kReach; u < luminance.width() - kReach; ++u) {
      if (is_labelled && labels.at(u, v) == 0) continue;
      across.add(luminance.pixel(u, v), 1);
      down.add(luminance.pixel(u, v), luminance.width());
      ++pixels;
    }
  }
  if (pixels < kFewest) return std::nullopt;
  return std::max(across.blurriness(), down.blurriness());
}

} // namespace kinora::encode
