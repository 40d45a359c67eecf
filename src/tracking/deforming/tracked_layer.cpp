#include "tracking/deforming/tracked_layer.h"

namespace kinora::tracking {

motion::Motion motion_of(const CanonicalModel& model, const NodeTrajectory& trajectory) {
  return motion::Motion::deforming(model.graph_in_world(), trajectory.deformations(model.origin()));
}

} // namespace kinora::tracking
