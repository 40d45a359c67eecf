// Where a rigid thing is expected next if it goes on as it has.
#pragma once

#include "core/se3.h"

namespace kinora::tracking {

/// How much farther than from one frame to the other it is to a third one; at most three times as far, so that nothing
/// runs away. Seconds, in order; 1 if the first two are of one time.
double steps_ahead(double earlier, double last, double next);

/// `steps` times the motion from `earlier` to `last` after `last`: the point `pivot`, which is in the thing's own
/// space, goes straight on, and the thing turns about it.
SE3 extrapolated(const SE3& earlier, const SE3& last, const Eigen::Vector3d& pivot, double steps);

} // namespace kinora::tracking
