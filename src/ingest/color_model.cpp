#include "ingest/color_model.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace kinora::ingest {
namespace {

constexpr float kUnseen = 2e-4F; ///< likelihood of a colour that was never counted
constexpr float kMaxLogRatio = 5;

} // namespace

std::size_t ColorModel::bin_of(const std::uint8_t* rgb) {
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

void ColorModel::add(const ColorModel& other) {
  for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
}

void ColorModel::finish() {
  const auto blur = [this](std::size_t stride, std::size_t length) {
    const std::array<float, kLights* kSteps* kSteps> before = counts_;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      const std::size_t place = i / stride % length;
      counts_[i] = 0.5F * before[i] + 0.25F * before[place > 0 ? i - stride : i] +
                   0.25F * before[place + 1 < length ? i + stride : i];
    }
  };
  blur(1, kSteps);
  blur(kSteps, kSteps);
  blur(kSteps * kSteps, kLights);
  const float sum = std::accumulate(counts_.begin(), counts_.end(), 0.0F);
  if (sum > 0)
    for (float& count : counts_) count /= sum;
}

bool ColorModel::empty() const {
  return std::all_of(counts_.begin(), counts_.end(), [](float count) { return count == 0; });
}

float ColorModel::share_against(const ColorModel& other, const std::uint8_t* rgb) const {
  const std::size_t bin = bin_of(rgb);
  const float both = counts_[bin] + other.counts_[bin];
  return both > 0 ? counts_[bin] / both : 1;
}

float ColorModel::log_ratio(const ColorModel& other, const std::uint8_t* rgb) const {
  const std::size_t bin = bin_of(rgb);
  return std::clamp(std::log((counts_[bin] + kUnseen) / (other.counts_[bin] + kUnseen)), -kMaxLogRatio, kMaxLogRatio);
}

double ColorModel::overlap(const ColorModel& other) const {
  double sum = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) sum += std::min(counts_[i], other.counts_[i]);
  return sum;
}

} // namespace kinora::ingest
