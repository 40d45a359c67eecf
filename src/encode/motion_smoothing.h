// Takes the tremble out of a deforming motion: what a tracker sees of one frame moves nodes about paths that are
// smooth. Source: Savitzky and Golay, "Smoothing and differentiation of data by simplified least squares procedures",
// Analytical Chemistry 36(8), 1964.
#pragma once

#include "motion/motion.h"

namespace kinora::encode {

/// A deforming motion whose nodes are, in each tracked frame, brought to the parabola that is nearest to nine tracked
/// frames in a row, the frame in the middle of them or as near to it as there are any: less where that is farther than
/// a tracker errs, because there a node changed its pace, and by 2.5 mm at most. Frames of shorter rows stay as they
/// are. Thread-safe.
motion::Motion smoothed_in_time(const motion::Motion& motion);

} // namespace kinora::encode
