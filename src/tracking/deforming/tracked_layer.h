// What is known of a deforming layer once all its frames have been looked at.
#pragma once

#include <vector>

#include "motion/motion.h"
#include "tracking/deforming/canonical_model.h"
#include "tracking/deforming/layer_body.h"
#include "tracking/deforming/node_trajectory.h"

namespace kinora::tracking {

/// Plain data.
struct TrackedLayer {
  /// One deformation for each frame. Canonical space = world at the layer's first frame, or at a later one in which
  /// surfaces are apart that touched before; the frames before the first are kLost and have that frame's deformation.
  motion::Motion motion;
  std::vector<GraphEdge> edges; ///< which nodes of the motion's graph hold each other
  double node_spacing;          ///< metres
  LayerBody body;               ///< the skeleton beside the graph
};

motion::Motion motion_of(const CanonicalModel& model, const NodeTrajectory& trajectory);

} // namespace kinora::tracking
