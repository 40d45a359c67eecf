#include "core/dual_quaternion.h"

#include <algorithm>

namespace kinora {

DualQuaternion DualQuaternion::from(const SE3& transform) {
  return from(Eigen::Quaterniond(transform.linear()).normalized(), transform.translation());
}

DualQuaternion DualQuaternion::from(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation) {
  const Eigen::Vector3d half = 0.5 * translation;
  return {rotation, Eigen::Quaterniond(0, half.x(), half.y(), half.z()) * rotation};
}

SE3 DualQuaternion::to_se3() const {
  SE3 transform = SE3::Identity();
  transform.linear() = real.toRotationMatrix();
  transform.translation() = 2.0 * (dual * real.conjugate()).vec();
  return transform;
}

DualQuaternion operator*(const DualQuaternion& second, const DualQuaternion& first) {
  DualQuaternion result;
  result.real = second.real * first.real;
  result.dual.coeffs() = (second.real * first.dual).coeffs() + (second.dual * first.real).coeffs();
  const double norm = result.real.norm();
  result.real.coeffs() /= norm;
  result.dual.coeffs() /= norm;
  result.dual.coeffs() -= result.real.coeffs() * result.real.coeffs().dot(result.dual.coeffs());
  return result;
}

double DualQuaternionSum::add(const DualQuaternion& transform, double weight) {
  const double sign = transform.real.coeffs().dot(heaviest_) < 0 ? -1.0 : 1.0;
  real_ += sign * weight * transform.real.coeffs();
  dual_ += sign * weight * transform.dual.coeffs();
  return sign;
}

DualQuaternionSum::Normalised DualQuaternionSum::normalised() const {
  Normalised result;
  result.real_norm = real_.norm();
  result.dual_norm = real_.dot(dual_) / result.real_norm;
  const Eigen::Vector4d real = real_ / result.real_norm;
  Eigen::Vector4d dual = dual_ / result.real_norm;
  dual -= real * real.dot(dual); // back onto the unit dual quaternions
  result.transform.real.coeffs() = real;
  result.transform.dual.coeffs() = dual;
  return result;
}

DualQuaternion blend(std::span<const DualQuaternion> transforms, std::span<const double> weights) {
  const auto heaviest = static_cast<std::size_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  if (!(weights[heaviest] > 0)) return transforms[heaviest];
  DualQuaternionSum sum(transforms[heaviest].real);
  for (std::size_t i = 0; i < transforms.size(); ++i) sum.add(transforms[i], weights[i]);
  return sum.normalised().transform;
}

} // namespace kinora
