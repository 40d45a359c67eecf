// The points of a layer where its nodes have them: blended once, read by all that is asked about those states.
#pragma once

#include <span>
#include <vector>

#include "tracking/blended_motion.h"

namespace kinora::tracking {

/// A point of the model with the nodes that carry it. Canonical, relative to the layer's origin.
struct SkinnedPoint {
  Eigen::Vector3d position;
  Eigen::Vector3d normal;
  Influence influence;
};

/// Plain data.
struct LayerPose {
  NodeStates nodes;
  std::vector<BlendedMotion> motions;  ///< of each point
  std::vector<Eigen::Vector3d> places; ///< of each point, in the camera
};

/// Uses all threads; same bits for any number of them.
LayerPose pose_layer(std::span<const SkinnedPoint> points, NodeStates nodes);

} // namespace kinora::tracking
