#include "tracking/deforming/layer_binding.h"

#include <algorithm>
#include <iterator>

#include <Eigen/Geometry>

namespace kinora::tracking {

void LayerBinding::track(const LayerView& view, const SE3& camera_to_world, double time,
                         std::span<const NearbyObject> objects) {
  seen_.clear();
  if (config_.use_body) body_.track(view, camera_to_world, time, objects);
}

NodeConstraints LayerBinding::constraints(const CanonicalModel& model, std::size_t frame, const SE3& world_to_camera,
                                          std::span<const NearbyObject> objects) const {
  NodeConstraints constraints;
  constraints.targets = body_.targets(frame, world_to_camera);
  constraints.targets.resize(model.nodes().size());
  for (std::size_t n = 0; n < model.nodes().size(); ++n) {
    const auto position = contacts_.position_of(n, objects);
    if (position) constraints.targets[n] = {world_to_camera * *position, 1 / config_.contact_sigma};
  }
  // Bones tell which surfaces only happen to be side by side, where they have a say.
  const auto has_target = [&](std::size_t node) { return constraints.targets[node].scale > 0; };
  std::copy_if(model.edges().begin(), model.edges().end(), std::back_inserter(constraints.edges),
               [&](const GraphEdge& edge) {
                 const auto a = static_cast<std::size_t>(edge.a);
                 const auto b = static_cast<std::size_t>(edge.b);
                 return !(has_target(a) && has_target(b) && body_.are_disconnected(a, b));
               });
  return constraints;
}

std::vector<SE3> LayerBinding::bone_driven_nodes(const CanonicalModel& model, std::size_t frame) const {
  std::vector<SE3> nodes = body_.node_transforms(frame);
  if (nodes.size() != model.nodes().size()) return {};
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    nodes[n].translation() -= model.origin() + nodes[n].linear() * model.nodes()[n];
    nodes[n] = renormalized(nodes[n]);
  }
  return nodes;
}

void LayerBinding::update(const CanonicalModel& model, const NodeTrajectory& trajectory, std::span<const double> seen,
                          std::span<const NearbyObject> objects) {
  seen_.assign(seen.begin(), seen.end());
  seen_.resize(model.nodes().size(), 0);
  std::vector<Eigen::Vector3d> positions;
  std::vector<SE3> nodes;
  for (std::size_t n = 0; n < model.nodes().size(); ++n) {
    const SE3& node = trajectory.last().nodes[n];
    nodes.push_back(node);
    nodes.back().translation() = positions.emplace_back(model.origin() + node * model.nodes()[n]);
  }
  if (config_.use_body) body_.update(nodes, seen_);
  contacts_.update(objects, positions, seen_);
  for (const NearbyObject& object : objects) last_contact_[object.label] = trajectory.frame_count() - 1;
}

void LayerBinding::set_canonical_pose(std::span<const SE3> pose) {
  std::vector<Eigen::Quaterniond> rotations;
  rotations.reserve(pose.size());
  for (const SE3& node : pose) rotations.emplace_back(node.linear());
  body_.apply_inverse_rotation(rotations);
}

// Source: Umeyama, "Least-Squares Estimation of Transformation Parameters Between Two Point Patterns", PAMI 13(4),
// 1991.
std::optional<SE3> LayerBinding::contact_motion(int label, const CanonicalModel& model,
                                                const NodeTrajectory& trajectory) const {
  constexpr double kMinVisible = 0.5;
  constexpr double kArm = 0.03; // metres, from a node to the points that stand for its rotation
  const auto contact = last_contact_.find(label);
  if (contact == last_contact_.end() || seen_.empty()) return std::nullopt;
  const std::vector<SE3>& then = trajectory.at(contact->second).nodes;
  const std::vector<SE3>& now = trajectory.last().nodes;
  std::vector<std::size_t> seen;
  std::vector<std::size_t> on_limbs;
  for (std::size_t n = 0; n < std::min(then.size(), seen_.size()); ++n) {
    if (!contacts_.is_in_contact(n, label)) continue;
    const auto limb = body_.limb_of(n);
    if (seen_[n] > kMinVisible) seen.push_back(n);
    if (limb && body_.is_visible(*limb)) on_limbs.push_back(n);
  }
  const std::vector<std::size_t>& contact_nodes = seen.empty() ? on_limbs : seen;
  if (contact_nodes.empty()) return std::nullopt;
  Eigen::Matrix3Xd before(3, 4 * static_cast<Eigen::Index>(contact_nodes.size()));
  Eigen::Matrix3Xd after = before;
  Eigen::Index column = 0;
  for (const std::size_t n : contact_nodes) {
    for (int axis = -1; axis < 3; ++axis, ++column) {
      Eigen::Vector3d point = model.nodes()[n];
      if (axis >= 0) point[axis] += kArm;
      before.col(column) = model.origin() + then[n] * point;
      after.col(column) = model.origin() + now[n] * point;
    }
  }
  return renormalized(SE3(Eigen::umeyama(before, after, false)));
}

} // namespace kinora::tracking
