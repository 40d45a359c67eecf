#include "core/rolling_shutter.h"

#include <cstddef>

#include "core/velocity.h"

namespace kinora {

std::vector<Twist> readout_motion(std::span<const SE3> camera_to_world, std::span<const double> times, double seconds) {
  std::vector<Twist> motion;
  motion.reserve(camera_to_world.size());
  for (std::size_t f = 0; f < camera_to_world.size(); ++f)
    motion.emplace_back(seconds * velocity_at(f, camera_to_world, times));
  return motion;
}

} // namespace kinora
