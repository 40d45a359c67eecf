// A frame with fewer pixels, each of which shows as much as several: depth cameras measure some hundred points along a
// side, however fine the colour is, and what neighbouring pixels tell together is meant for such points.
#pragma once

#include "ingest/frame/frame.h"

namespace kinora::ingest {

/// The same frame, `factor` × `factor` pixels become one. Labels are those of the block's middle; depth
/// is the mean of what has that label and lies on its nearest surface, metres; colour is the block's mean. What is left
/// over at the right and at the bottom is left out. Thread-safe.
Frame reduced_frame(const Frame& frame, int factor);

} // namespace kinora::ingest
