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

DualQuaternion blend(std::span<const DualQuaternion> transforms, std::span<const double> weights) {
  constexpr double kVanishing = 1e-8;
  const std::size_t heaviest =
      static_cast<std::size_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  const DualQuaternion& pivot = transforms[heaviest];
  Eigen::Vector4d real = Eigen::Vector4d::Zero();
  Eigen::Vector4d dual = Eigen::Vector4d::Zero();
  double total = 0;
  for (std::size_t i = 0; i < transforms.size(); ++i) {
    const double sign = transforms[i].real.coeffs().dot(pivot.real.coeffs()) < 0 ? -1.0 : 1.0;
    real += sign * weights[i] * transforms[i].real.coeffs();
    dual += sign * weights[i] * transforms[i].dual.coeffs();
    total += weights[i];
  }
  const double norm = real.norm();
  if (!(total > 0) || !(norm > kVanishing * total)) return pivot;
  real /= norm;
  dual /= norm;
  dual -= real * real.dot(dual); // back onto the unit dual quaternions
  DualQuaternion result;
  result.real.coeffs() = real;
  result.dual.coeffs() = dual;
  return result;
}

} // namespace kinora
