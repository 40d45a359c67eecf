#include "motion/skinning/blended_motion.h"

#include <cmath>

namespace kinora::motion {
namespace {

// The rotation about an axis by its length, radians.
Eigen::Quaterniond exp_rotation(const Eigen::Vector3d& rotation) {
  const double angle = rotation.norm();
  const double share = angle > 1e-6 ? std::sin(0.5 * angle) / angle : 0.5 - angle * angle / 48;
  const Eigen::Vector3d axis = share * rotation;
  return {std::cos(0.5 * angle), axis.x(), axis.y(), axis.z()};
}

} // namespace

void NodeStates::push_back(const DualQuaternion& transform, const Eigen::Vector3d& canonical_node) {
  transforms.push_back(transform);
  positions.emplace_back(transform.to_se3() * canonical_node);
}

void NodeStates::push_back(const SE3& transform, const Eigen::Vector3d& canonical_node) {
  transforms.push_back(DualQuaternion::from(transform));
  positions.emplace_back(transform * canonical_node);
}

NodeStates stepped(const NodeStates& states, std::span<const Twist> step) {
  NodeStates result = states;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Eigen::Vector3d& centre = states.positions[i];
    const Eigen::Quaterniond rotation = exp_rotation(step[i].tail<3>());
    const Eigen::Vector3d translation = centre + step[i].head<3>() - rotation * centre;
    result.transforms[i] = DualQuaternion::from(rotation, translation) * states.transforms[i];
    result.positions[i] = centre + step[i].head<3>();
  }
  return result;
}

NodeStates moved(const NodeStates& states, const SE3& motion) {
  NodeStates result = states;
  const DualQuaternion first = DualQuaternion::from(motion);
  for (std::size_t i = 0; i < states.size(); ++i) {
    result.transforms[i] = first * states.transforms[i];
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

BlendedMotion blend_motion(std::span<const DualQuaternion> transforms, const Influence& influence) {
  BlendedMotion result;
  DualQuaternionSum sum(transforms[static_cast<std::size_t>(influence.nodes[0])].real);
  for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
    result.signs[k] = sum.add(transforms[static_cast<std::size_t>(influence.nodes[k])], influence.weights[k]);
  }
  const DualQuaternionSum::Normalised blended = sum.normalised();
  result.transform = blended.transform;
  result.real_norm = blended.real_norm;
  result.dual_norm = blended.dual_norm;
  return result;
}

BlendedMotion blend_motion(const NodeStates& states, const Influence& influence) {
  return blend_motion(states.transforms, influence);
}

// Real and dual: D = q · blended⁻¹ / norm, a dual number short of it, which normalisation takes out as it does what is
// not pure.
NodeJacobian::NodeJacobian(const NodeStates& states, const Influence& influence, const BlendedMotion& blended,
                           std::size_t slot)
    : position_(states.positions[static_cast<std::size_t>(influence.nodes[slot])]) {
  const DualQuaternion& q = states.transforms[static_cast<std::size_t>(influence.nodes[slot])];
  const Eigen::Quaterniond back = blended.transform.real.conjugate();
  const double share = blended.signs[slot] * influence.weights[slot] / blended.real_norm;
  real_ = q.real * back;
  dual_ = q.dual * back;
  dual_.coeffs() += (q.real * blended.transform.dual.conjugate()).coeffs();
  dual_.coeffs() = share * (dual_.coeffs() - blended.dual_norm / blended.real_norm * real_.coeffs());
  real_.coeffs() *= share;
}

Twist NodeJacobian::pullback(const Eigen::Vector3d& g, const Eigen::Vector3d& m) const {
  const auto v = real_.vec();
  const double w = real_.w();
  const Eigen::Vector3d translation = w * g + v.cross(g);
  Twist result;
  result.head<3>() = translation;
  result.tail<3>() = dual_.w() * g + dual_.vec().cross(g) + w * m + v.cross(m) + translation.cross(position_);
  return result;
}

} // namespace kinora::motion
