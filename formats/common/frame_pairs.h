// Which depth image belongs to which colour image, by their times.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace kinora::formats {

/// Numbers in two lists, of a colour and a depth image.
using FramePair = std::pair<std::size_t, std::size_t>;

/// For every colour image the depth image nearest in time, if it is within `tolerance` seconds; each depth image once,
/// for the colour image that is nearest to it. Both lists are in order of time, and so is the result.
std::vector<FramePair> pair_by_time(const std::vector<double>& colors, const std::vector<double>& depths,
                                    double tolerance);

/// The members `time` of a list.
template <class Stamped> std::vector<double> times_of(const std::vector<Stamped>& list) {
  std::vector<double> times;
  times.reserve(list.size());
  for (const Stamped& entry : list) times.push_back(entry.time);
  return times;
}

/// Sorts by the member `time`; whether anything was out of order.
template <class Stamped> bool put_in_order(std::vector<Stamped>& list) {
  const auto earlier = [](const Stamped& a, const Stamped& b) { return a.time < b.time; };
  if (std::is_sorted(list.begin(), list.end(), earlier)) return false;
  std::stable_sort(list.begin(), list.end(), earlier);
  return true;
}

/// Frames per second from the median step between times in order; 30 if there are fewer than two.
double median_rate(const std::vector<double>& times);

} // namespace kinora::formats
