// Unit dual quaternions and their blending.
// Source: Kavan et al., "Geometric Skinning with Approximate Dual Quaternion Blending", ACM TOG 27(4), 2008.
#pragma once

#include <span>

#include "core/se3.h"

namespace kinora {

/// A rigid transform as real + ε·dual with dual = ½ · translation · real. q and −q are the same transform.
struct DualQuaternion {
  Eigen::Quaterniond real = Eigen::Quaterniond::Identity();
  Eigen::Quaterniond dual = Eigen::Quaterniond(0, 0, 0, 0);

  static DualQuaternion from(const SE3& transform);
  /// `rotation`: of unit length.
  static DualQuaternion from(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation);
  SE3 to_se3() const;
};

/// `first`, then `second`; normalised.
DualQuaternion operator*(const DualQuaternion& second, const DualQuaternion& first);

/// Weighted blend (DLB). Every quaternion is flipped to the hemisphere of the heaviest one; the result is
/// normalised; if the weights, or the blended rotation, vanish, the heaviest transform is returned alone.
/// Sizes must agree and be at least one; weights are not negative. Thread-safe.
DualQuaternion blend(std::span<const DualQuaternion> transforms, std::span<const double> weights);

} // namespace kinora
