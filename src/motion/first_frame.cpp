#include "motion/first_frame.h"

namespace kinora::motion {

std::size_t first_frame_of(const Motion& motion, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    if (motion.health(i) != Health::kLost) return i;
  }
  return 0;
}

} // namespace kinora::motion
