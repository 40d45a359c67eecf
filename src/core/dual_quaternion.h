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

/// The sum of weighed transforms from which blending (DLB) makes one: what every way of blending rests on.
///
/// Each is added in the hemisphere of the heaviest, q₀. That such a sum vanishes cannot happen, so that nothing here
/// has a threshold for it: for unit quaternions and weights that are not negative |Σ wₖ sₖ qₖ| ≥ q₀ · Σ wₖ sₖ qₖ = Σ wₖ
/// |q₀ · qₖ| ≥ w₀, and the heaviest of n has at least an n-th of all the weight.
class DualQuaternionSum {
public:
  /// `heaviest`: the rotation of the transform with the largest weight, of unit length.
  explicit DualQuaternionSum(const Eigen::Quaterniond& heaviest) : heaviest_(heaviest.coeffs()) {}

  /// Returns the sign, ±1, that brings the transform into the hemisphere.
  double add(const DualQuaternion& transform, double weight);

  /// The sum over its norm, which is the dual number real_norm + ε·dual_norm. Weights that add up to nothing have none.
  struct Normalised {
    DualQuaternion transform;
    double real_norm;
    double dual_norm;
  };
  Normalised normalised() const;

private:
  Eigen::Vector4d heaviest_;
  Eigen::Vector4d real_ = Eigen::Vector4d::Zero();
  Eigen::Vector4d dual_ = Eigen::Vector4d::Zero();
};

/// Weighted blend (DLB), normalised; if all weights are zero, the first transform.
/// Sizes must agree and be at least one; weights are not negative. Thread-safe.
DualQuaternion blend(std::span<const DualQuaternion> transforms, std::span<const double> weights);

} // namespace kinora
