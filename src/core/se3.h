// Rigid motions of space, their logarithm, and interpolation between them.
// Source: Eade, "Lie Groups for 2D and 3D Transformations" (2017); Sola et al., arXiv:1812.01537.
#pragma once

#include <Eigen/Geometry>

namespace kinora {

/// A rigid transform in double. `a_to_b * point_in_a` is the point in b. Metres.
using SE3 = Eigen::Isometry3d;

/// A twist: rows 0–2 translation part (metres), rows 3–5 rotation vector (radians).
using Twist = Eigen::Matrix<double, 6, 1>;

/// Skew-symmetric matrix with skew(a) * b = a × b.
Eigen::Matrix3d skew(const Eigen::Vector3d& a);

/// Exponential of a twist. Finite for every finite input; exact to rounding near zero and near π.
SE3 exp_se3(const Twist& twist);

/// Logarithm; the rotation angle lies in [0, π]. exp_se3(log_se3(T)) = T to 1e-9, also at 179.9°.
Twist log_se3(const SE3& transform);

/// Angle of the rotation part in radians, in [0, π].
double rotation_angle(const SE3& transform);

/// The transform at `fraction` of the way from a to b: a · exp(fraction · log(a⁻¹ b)).
SE3 interpolate(const SE3& a, const SE3& b, double fraction);

/// The same with a rotation that is one to rounding again, after many products.
SE3 renormalized(const SE3& transform);

/// The nearest rigid transform to a 4×4 matrix that is rigid up to `tolerance`.
/// Throws Error(kCorruptInput) naming `what` if it is not: not finite, a reflection, a scale, or a wrong last row.
SE3 rigid_from_matrix(const Eigen::Matrix4d& matrix, const char* what, double tolerance = 1e-2);

} // namespace kinora
