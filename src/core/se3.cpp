#include "core/se3.h"

#include <cmath>
#include <string>

#include <Eigen/SVD>

#include "core/error.h"

namespace kinora {
namespace {

// Left Jacobian coefficients of SO(3): b = (1 - cos θ)/θ², c = (θ - sin θ)/θ³, by series near zero.
struct JacobianCoefficients {
  double b;
  double c;
};

JacobianCoefficients jacobian_coefficients(double angle) {
  const double squared = angle * angle;
  if (angle < 1e-4) return {0.5 - squared / 24.0, 1.0 / 6.0 - squared / 120.0};
  return {(1.0 - std::cos(angle)) / squared, (angle - std::sin(angle)) / (squared * angle)};
}

Eigen::Quaterniond exp_so3(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  const double half_sinc = angle < 1e-6 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  const Eigen::Vector3d imaginary = half_sinc * rotation_vector;
  return Eigen::Quaterniond(std::cos(0.5 * angle), imaginary.x(), imaginary.y(), imaginary.z()).normalized();
}

Eigen::Vector3d log_so3(const Eigen::Matrix3d& rotation) {
  Eigen::Quaterniond q(rotation);
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  const double half_angle = std::atan2(sine, q.w());
  const double scale = sine < 1e-9 ? 2.0 : 2.0 * half_angle / sine;
  return scale * q.vec();
}

} // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

SE3 exp_se3(const Twist& twist) {
  const Eigen::Vector3d omega = twist.tail<3>();
  const auto [b, c] = jacobian_coefficients(omega.norm());
  const Eigen::Matrix3d w = skew(omega);
  const Eigen::Matrix3d jacobian = Eigen::Matrix3d::Identity() + b * w + c * w * w;
  SE3 transform = SE3::Identity();
  transform.linear() = exp_so3(omega).toRotationMatrix();
  transform.translation() = jacobian * twist.head<3>();
  return transform;
}

Twist log_se3(const SE3& transform) {
  const Eigen::Vector3d omega = log_so3(transform.linear());
  const auto [b, c] = jacobian_coefficients(omega.norm());
  const Eigen::Matrix3d w = skew(omega);
  const Eigen::Matrix3d jacobian = Eigen::Matrix3d::Identity() + b * w + c * w * w;
  Twist twist;
  twist << jacobian.partialPivLu().solve(transform.translation()), omega;
  return twist;
}

double rotation_angle(const SE3& transform) { return log_so3(transform.linear()).norm(); }

SE3 interpolate(const SE3& a, const SE3& b, double fraction) {
  return a * exp_se3(fraction * log_se3(a.inverse() * b));
}

SE3 renormalized(const SE3& transform) {
  SE3 result = transform;
  result.linear() = Eigen::Quaterniond(transform.linear()).normalized().toRotationMatrix();
  return result;
}

SE3 rigid_from_matrix(const Eigen::Matrix4d& matrix, const char* what, double tolerance) {
  const auto reject = [what](const char* why) {
    throw Error(ErrorCode::kCorruptInput, std::string(what) + " is not a rigid 4x4 transform (" + why +
                                              "); write it row by row, rotation and translation in metres");
  };
  if (!matrix.allFinite()) reject("it holds values that are not finite");
  if ((matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > tolerance) {
    reject("its last row is not 0 0 0 1");
  }
  const Eigen::Matrix3d linear = matrix.topLeftCorner<3, 3>();
  if ((linear * linear.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > tolerance) {
    reject("its rotation part is not orthonormal");
  }
  if (linear.determinant() < 0) reject("its rotation part is a reflection");
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
  SE3 transform = SE3::Identity();
  transform.linear() = svd.matrixU() * svd.matrixV().transpose();
  transform.translation() = matrix.topRightCorner<3, 1>();
  return transform;
}

} // namespace kinora
