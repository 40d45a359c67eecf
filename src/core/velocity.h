// How fast something moves along a path of poses.
#pragma once

#include <cstddef>
#include <span>

#include "core/se3.h"

namespace kinora {

/// Velocity of what was at `a` and is at `b` so many seconds later, in its own space, per second; zero if they are not
/// positive.
Twist velocity_between(const SE3& a, const SE3& b, double seconds);

/// Along a path that has a pose for each of `times` (seconds), from the pose before to the one after.
Twist velocity_at(std::size_t index, std::span<const SE3> path, std::span<const double> times);

} // namespace kinora
