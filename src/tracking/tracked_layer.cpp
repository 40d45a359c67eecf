#include "tracking/tracked_layer.h"

namespace kinora::tracking {

Motion motion_of(const CanonicalModel& model, const NodeTrajectory& trajectory) {
  return Motion::deforming(model.graph_in_world(), trajectory.deformations(model.origin()));
}

} // namespace kinora::tracking
