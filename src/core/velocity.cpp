#include "core/velocity.h"

#include <algorithm>

namespace kinora {

Twist velocity_between(const SE3& a, const SE3& b, double seconds) {
  return seconds > 0 ? Twist(log_se3(a.inverse() * b) / seconds) : Twist::Zero();
}

Twist velocity_at(std::size_t index, std::span<const SE3> path, std::span<const double> times) {
  const std::size_t before = index - std::min<std::size_t>(index, 1);
  const std::size_t after = std::min(index + 1, path.size() - 1);
  return velocity_between(path[before], path[after], times[after] - times[before]);
}

} // namespace kinora
