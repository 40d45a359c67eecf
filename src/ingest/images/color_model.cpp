#include "ingest/images/color_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kinora::ingest {
namespace {

constexpr float kUnseen = 2e-4F; ///< likelihood of a colour that was never counted
constexpr float kMaxLogRatio = 5;

} // namespace

std::size_t ColorHistogram::bin_of(const std::uint8_t* rgb) {
  const int r = rgb[0], g = rgb[1], b = rgb[2];
  const int light = (77 * r + 150 * g + 29 * b) / 256;
  // Differences to grey within ±127; most colours lie in the middle, which gets the finer steps.
  const auto step = [](int difference) {
    const double t = difference / 127.0;
    const double stretched = 0.5 + 0.5 * std::copysign(std::sqrt(std::abs(t)), t);
    return static_cast<std::size_t>(std::clamp(stretched * kSteps, 0.0, kSteps - 1.0));
  };
  const auto light_step = static_cast<std::size_t>(light) * kLights / 256;
  return (light_step * kSteps + step((b - light) / 2)) * kSteps + step((r - light) / 2);
}

void ColorCounts::add(const ColorCounts& other) {
  for (std::size_t i = 0; i < counts_.bins.size(); ++i) counts_.bins[i] += other.counts_.bins[i];
}

float ColorCounts::share_against(const ColorCounts& other, const std::uint8_t* rgb) const {
  const std::size_t bin = ColorHistogram::bin_of(rgb);
  const float both = counts_.bins[bin] + other.counts_.bins[bin];
  return both > 0 ? counts_.bins[bin] / both : 1;
}

ColorModel ColorCounts::model() const {
  ColorModel model;
  auto& bins = model.likelihood_.bins;
  bins = counts_.bins;
  const auto blur = [&bins](std::size_t stride, std::size_t length) {
    const auto before = bins;
    for (std::size_t i = 0; i < bins.size(); ++i) {
      const std::size_t index = i / stride % length;
      bins[i] = 0.5F * before[i] + 0.25F * before[index > 0 ? i - stride : i] +
                0.25F * before[index + 1 < length ? i + stride : i];
    }
  };
  constexpr std::size_t kSteps = ColorHistogram::kSteps;
  blur(1, kSteps);
  blur(kSteps, kSteps);
  blur(kSteps * kSteps, ColorHistogram::kLights);
  const float sum = std::accumulate(bins.begin(), bins.end(), 0.0F);
  if (sum > 0)
    for (float& bin : bins) bin /= sum;
  return model;
}

float ColorModel::log_ratio(const ColorModel& other, const std::uint8_t* rgb) const {
  const std::size_t bin = ColorHistogram::bin_of(rgb);
  return std::clamp(std::log((likelihood_.bins[bin] + kUnseen) / (other.likelihood_.bins[bin] + kUnseen)),
                    -kMaxLogRatio, kMaxLogRatio);
}

double ColorModel::overlap(const ColorModel& other) const {
  double sum = 0;
  for (std::size_t i = 0; i < likelihood_.bins.size(); ++i) {
    sum += std::min(likelihood_.bins[i], other.likelihood_.bins[i]);
  }
  return sum;
}

} // namespace kinora::ingest
