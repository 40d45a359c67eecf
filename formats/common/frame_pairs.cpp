#include "common/frame_pairs.h"

#include <algorithm>
#include <cmath>

namespace kinora::formats {

std::vector<FramePair> pair_by_time(const std::vector<double>& colors, const std::vector<double>& depths,
                                    double tolerance) {
  std::vector<FramePair> pairs;
  for (std::size_t c = 0; c < colors.size() && !depths.empty(); ++c) {
    const auto difference = [&](std::size_t color, std::size_t depth) {
      return std::abs(colors[color] - depths[depth]);
    };
    auto nearest = static_cast<std::size_t>(std::lower_bound(depths.begin(), depths.end(), colors[c]) - depths.begin());
    if (nearest == depths.size() || (nearest > 0 && difference(c, nearest - 1) < difference(c, nearest))) --nearest;
    if (!(difference(c, nearest) <= tolerance)) continue;
    if (pairs.empty() || pairs.back().second != nearest)
      pairs.emplace_back(c, nearest);
    else if (difference(c, nearest) < difference(pairs.back().first, nearest))
      pairs.back().first = c;
  }
  return pairs;
}

double median_rate(const std::vector<double>& times) {
  constexpr double kDefaultRate = 30;
  constexpr double kMaxRate = 1e5;
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  if (steps.empty()) return kDefaultRate;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle > 1 / kMaxRate && std::isfinite(*middle) ? 1.0 / *middle : kDefaultRate;
}

} // namespace kinora::formats
