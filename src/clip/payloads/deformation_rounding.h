// Deformations rounded as coarsely as nobody sees.
#pragma once

#include <span>
#include <vector>

#include "clip/coding/node_quantiser.h"
#include "motion/motion.h"

namespace kinora::clip {

/// How far a point may be from where it was before its deformation was stored, metres. It is looked at at each node
/// and, along each axis, at a weight radius from it: surfaces are nearer to their nodes.
inline constexpr double kLargestMotionError = 0.5e-3;

/// Immutable, thread-safe.
class DeformationRounding {
public:
  explicit DeformationRounding(const motion::DeformationGraph& graph);

  /// States of all nodes, coarse ones but for those that a point needs finer (kCoarseSteps, kFineSteps). A deformation
  /// that was stored before stays as it is. Throws Error(kFailure) as quantise() does.
  std::vector<NodeState> rounded(std::span<const DualQuaternion> node_to_world,
                                 std::span<const RestPosition> rest) const;

private:
  struct Point {
    Eigen::Vector3d canonical;
    motion::Influence influence;
  };

  std::vector<Point> points_;
};

} // namespace kinora::clip
