#include "tracking/blended_motion.h"

namespace kinora::tracking {

void NodeStates::push_back(const DualQuaternion& transform, const Eigen::Vector3d& canonical_node) {
  transforms.push_back(transform);
  positions.emplace_back(transform.to_se3() * canonical_node);
}

NodeStates stepped(const NodeStates& states, std::span<const Twist> step) {
  NodeStates result = states;
  for (std::size_t i = 0; i < states.size(); ++i) {
    Twist rotation = Twist::Zero();
    rotation.tail<3>() = step[i].tail<3>();
    SE3 motion = exp_se3(rotation);
    const Eigen::Vector3d& centre = states.positions[i];
    motion.translation() = centre + step[i].head<3>() - motion.linear() * centre;
    result.transforms[i] = DualQuaternion::from(motion * states.transforms[i].to_se3());
    result.positions[i] = centre + step[i].head<3>();
  }
  return result;
}

NodeStates moved(const NodeStates& states, const SE3& motion) {
  NodeStates result = states;
  for (std::size_t i = 0; i < states.size(); ++i) {
    result.transforms[i] = DualQuaternion::from(motion * states.transforms[i].to_se3());
    result.positions[i] = motion * states.positions[i];
  }
  return result;
}

Eigen::Vector3d BlendedMotion::rotate(const Eigen::Vector3d& vector) const {
  const Eigen::Vector3d axis = transform.real.vec();
  const Eigen::Vector3d twice = 2.0 * axis.cross(vector);
  return vector + transform.real.w() * twice + axis.cross(twice);
}

Eigen::Vector3d BlendedMotion::apply(const Eigen::Vector3d& point) const {
  return rotate(point) + 2.0 * (transform.dual * transform.real.conjugate()).vec();
}

BlendedMotion blend_motion(const NodeStates& states, const Influence& influence) {
  constexpr double kVanishing = 1e-8; // as in kinora::blend
  BlendedMotion result;
  const DualQuaternion& heaviest = states.transforms[static_cast<std::size_t>(influence.nodes[0])];
  Eigen::Vector4d real = Eigen::Vector4d::Zero();
  Eigen::Vector4d dual = Eigen::Vector4d::Zero();
  for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
    const DualQuaternion& q = states.transforms[static_cast<std::size_t>(influence.nodes[k])];
    result.signs[k] = q.real.coeffs().dot(heaviest.real.coeffs()) < 0 ? -1.0 : 1.0;
    real += result.signs[k] * influence.weights[k] * q.real.coeffs();
    dual += result.signs[k] * influence.weights[k] * q.dual.coeffs();
  }
  const double norm = real.norm();
  if (!(norm > kVanishing)) {
    result.transform = heaviest;
    result.degenerate = true;
    return result;
  }
  result.real_norm = norm;
  result.dual_norm = real.dot(dual) / norm;
  real /= norm;
  dual = (dual - result.dual_norm * real) / norm;
  result.transform.real.coeffs() = real;
  result.transform.dual.coeffs() = dual;
  return result;
}

Twist pulled_back(const NodeStates& states, const Influence& influence, const BlendedMotion& blended, std::size_t slot,
                  const Eigen::Vector3d& g, const Eigen::Vector3d& m) {
  const auto node = static_cast<std::size_t>(influence.nodes[slot]);
  const DualQuaternion& q = states.transforms[node];
  Twist result;
  if (blended.degenerate) {
    result.head<3>() = slot == 0 ? g : Eigen::Vector3d::Zero();
    result.tail<3>() = slot == 0 ? Eigen::Vector3d(m + g.cross(states.positions[node])) : Eigen::Vector3d::Zero();
    return result;
  }
  // D = q · blended⁻¹ / norm, a dual quaternion; twists pass through it: (t, ω) of the node makes the pure part of
  // (ω + εt) · D in the blend. What is not pure is a dual number, which normalisation takes out.
  const Eigen::Quaterniond back = blended.transform.real.conjugate();
  const Eigen::Quaterniond real = q.real * back;
  Eigen::Quaterniond dual = q.dual * back;
  dual.coeffs() += (q.real * blended.transform.dual.conjugate()).coeffs();
  const double share = blended.signs[slot] * influence.weights[slot] / blended.real_norm;
  dual.coeffs() = share * (dual.coeffs() - blended.dual_norm / blended.real_norm * real.coeffs());
  const Eigen::Vector3d v = share * real.vec();
  const double w = share * real.w();
  const Eigen::Vector3d translation = w * g + v.cross(g);
  result.head<3>() = translation;
  result.tail<3>() =
      dual.w() * g + dual.vec().cross(g) + w * m + v.cross(m) + translation.cross(states.positions[node]);
  return result;
}

} // namespace kinora::tracking
