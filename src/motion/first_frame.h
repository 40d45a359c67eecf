// Since when a layer is there.
#pragma once

#include <cstddef>

#include "motion/motion.h"

namespace kinora::motion {

/// The first frame, of `count`, in which a layer with this motion has been seen: until then it is lost.
std::size_t first_frame_of(const Motion& motion, std::size_t count);

} // namespace kinora::motion
