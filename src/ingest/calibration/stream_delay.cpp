#include "ingest/calibration/stream_delay.h"

#include <array>

#include "core/linear_light.h"
#include "core/statistics.h"
#include "ingest/frame/reduced_view.h"

namespace kinora::ingest {
namespace {

constexpr int kColumns = 96; ///< of the grid of pixels that are looked at
constexpr int kRows = 72;
constexpr std::size_t kMinPixels = 200; ///< to tell a gain
constexpr float kDark = 0.01F;          ///< linear; darker is noise
constexpr float kBright = 0.9F;         ///< brighter may be saturated
constexpr double kMotion = 0.05;        ///< log ratio at which a pixel shows something else
constexpr int kMaxShift = 5;            ///< frames
constexpr std::size_t kMinFrames = 24;  ///< to tell a time offset
constexpr double kMinCorrelation = 0.7;
constexpr double kMinVariation = 0.3; ///< of a motion signal: standard deviation over mean

float linear_of(std::uint8_t value) {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = static_cast<float>(linear_light(static_cast<double>(i) / 255));
    }
    return values;
  }();
  return table[value];
}

/// Pearson correlation of depth_motion shifted by `shift` frames against color_motion.
double correlation(const std::vector<double>& color, const std::vector<double>& depth, int shift) {
  double sum_a = 0, sum_b = 0, sum_aa = 0, sum_bb = 0, sum_ab = 0, count = 0;
  for (int i = 0; i < static_cast<int>(color.size()); ++i) {
    const int j = i + shift;
    if (j < 0 || j >= static_cast<int>(depth.size())) continue;
    const double a = color[static_cast<std::size_t>(i)];
    const double b = depth[static_cast<std::size_t>(j)];
    sum_a += a, sum_b += b, sum_aa += a * a, sum_bb += b * b, sum_ab += a * b, ++count;
  }
  const double variance = (sum_aa - sum_a * sum_a / count) * (sum_bb - sum_b * sum_b / count);
  return variance > 0 ? (sum_ab - sum_a * sum_b / count) / std::sqrt(variance) : 0;
}

bool varies(const std::vector<double>& signal) {
  double sum = 0, squares = 0;
  for (const double value : signal) sum += value, squares += value * value;
  const auto count = static_cast<double>(signal.size());
  const double mean = sum / count;
  return mean > 0 && std::sqrt(std::max(0.0, squares / count - mean * mean)) > kMinVariation * mean;
}

} // namespace

StreamDelay::Sample StreamDelay::sample_of(const Frame& frame) {
  Sample sample;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const int u = (2 * column + 1) * frame.color.width() / (2 * kColumns);
      const int v = (2 * row + 1) * frame.color.height() / (2 * kRows);
      const std::uint8_t* rgb = frame.color.pixel(u, v);
      const float light = 0.2126F * linear_of(rgb[0]) + 0.7152F * linear_of(rgb[1]) + 0.0722F * linear_of(rgb[2]);
      const bool usable = light > kDark && light < kBright && std::max({rgb[0], rgb[1], rgb[2]}) < 250;
      sample.brightness.push_back(usable ? std::optional(light) : std::nullopt);
      sample.depth.push_back(frame.depth.at(u, v));
    }
  }
  return sample;
}

std::optional<double> StreamDelay::gain_against(const Sample& sample, const Sample& reference) const {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < sample.brightness.size(); ++i) {
    if (!sample.brightness[i] || !reference.brightness[i]) continue;
    const float z = reference.depth[i];
    const bool both = z > 0 && sample.depth[i] > 0;
    if (both ? std::abs(z - sample.depth[i]) > same_surface_tolerance(z) : z > 0 || sample.depth[i] > 0) continue;
    ratios.push_back(std::log(*sample.brightness[i] / *reference.brightness[i]));
  }
  if (ratios.size() < kMinPixels) return std::nullopt;
  return std::exp(median(ratios));
}

void StreamDelay::add(const Frame& frame) {
  Sample sample = sample_of(frame);
  times_.push_back(frame.time);
  if (times_.size() == 1) {
    reference_ = last_ = std::move(sample);
    return;
  }
  const double before = last_gain_;
  std::optional<double> gain = gain_against(sample, reference_);
  if (!gain) { // the view has changed: from the last frame on there is another reference
    reference_ = last_;
    reference_gain_ = before;
    gain = gain_against(sample, reference_);
  }
  last_gain_ = gain ? reference_gain_ * *gain : before;
  const double step = std::log(last_gain_ / before);
  double changed_color = 0, changed_depth = 0;
  for (std::size_t i = 0; i < sample.brightness.size(); ++i) {
    if (sample.brightness[i] && last_.brightness[i]) {
      const double change = std::abs(std::log(*sample.brightness[i] / *last_.brightness[i]) - step);
      changed_color += std::min(change, 1.0) > kMotion ? change : 0;
    }
    const float z = std::min(last_.depth[i], sample.depth[i]);
    if (z > 0 && std::abs(last_.depth[i] - sample.depth[i]) > same_surface_tolerance(z)) ++changed_depth;
  }
  color_motion_.push_back(changed_color);
  depth_motion_.push_back(changed_depth);
  last_ = std::move(sample);
}

std::optional<double> StreamDelay::seconds() const {
  if (times_.size() < kMinFrames || !varies(color_motion_) || !varies(depth_motion_)) return std::nullopt;
  std::array<double, 2 * kMaxShift + 1> scores{};
  for (int shift = -kMaxShift; shift <= kMaxShift; ++shift)
    scores[static_cast<std::size_t>(shift) + kMaxShift] = correlation(color_motion_, depth_motion_, shift);
  const auto best = static_cast<std::size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin());
  if (scores[best] < kMinCorrelation || best == 0 || best + 1 == scores.size()) return std::nullopt;
  const double left = scores[best - 1], middle = scores[best], right = scores[best + 1];
  const double curvature = left - 2 * middle + right;
  const double fraction = curvature < 0 ? 0.5 * (left - right) / curvature : 0;
  const double interval = (times_.back() - times_.front()) / static_cast<double>(times_.size() - 1);
  return (static_cast<double>(best) - kMaxShift + fraction) * interval;
}

} // namespace kinora::ingest
