// How nodes of a deformation graph differ between two motions.
#pragma once

#include "core/dual_quaternion.h"
#include "core/se3.h"

namespace kinora::encode {

/// From `before` to `after`, both canonical to world, as a twist about the node's own place in canonical space: metres,
/// radians.
inline Twist correction_of(const Eigen::Vector3d& node, const DualQuaternion& before, const DualQuaternion& after) {
  return log_se3(
      SE3(Eigen::Translation3d(-node) * before.to_se3().inverse() * after.to_se3() * Eigen::Translation3d(node)));
}

/// correction_of(node, before, corrected(node, before, c)) = c.
inline DualQuaternion corrected(const Eigen::Vector3d& node, const DualQuaternion& before, const Twist& correction) {
  return DualQuaternion::from(
      SE3(before.to_se3() * Eigen::Translation3d(node) * exp_se3(correction) * Eigen::Translation3d(-node)));
}

} // namespace kinora::encode
