// Order statistics that the room shares.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace kinora {

/// The middle value (the upper of two); reorders `values`, which must not be empty.
template <class Number> Number median(std::vector<Number>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Standard deviation of normal errors over the median of their sizes: a deviation that outliers leave alone.
inline constexpr double kDeviationPerMedian = 1.4826;

} // namespace kinora
