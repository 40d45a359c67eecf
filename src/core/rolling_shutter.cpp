#include "core/rolling_shutter.h"

#include <algorithm>
#include <cstddef>

#include "core/velocity.h"

namespace kinora {
namespace {

constexpr double kJump = 5; // a path that is so many times as fast on one side of a frame does not move on but jumps

Twist velocity_without_jumps(std::size_t f, std::span<const SE3> path, std::span<const double> times) {
  if (f == 0 || f + 1 == path.size()) return velocity_at(f, path, times);
  Twist before = velocity_between(path[f - 1], path[f], times[f] - times[f - 1]);
  Twist after = velocity_between(path[f], path[f + 1], times[f + 1] - times[f]);
  if (before.norm() > kJump * after.norm()) return after;
  if (after.norm() > kJump * before.norm()) return before;
  return velocity_at(f, path, times);
}

} // namespace

std::vector<Twist> readout_motion(std::span<const SE3> camera_to_world, std::span<const double> times, double seconds) {
  std::vector<Twist> motion;
  motion.reserve(camera_to_world.size());
  for (std::size_t f = 0; f < camera_to_world.size(); ++f) {
    motion.emplace_back(seconds * velocity_without_jumps(f, camera_to_world, times));
  }
  return motion;
}

} // namespace kinora
