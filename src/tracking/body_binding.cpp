#include "tracking/body_binding.h"

#include "tracking/body/limbs.h"

namespace kinora::tracking {
namespace {

constexpr double kRenewed = 0.2; // share of what one frame says: bones jitter from frame to frame

bool is_lost(Joint bone, const std::array<LimbHealth, kLimbs>& limbs) {
  const std::optional<Limb> limb = limb_of(bone);
  return limb && limbs[*limb] == LimbHealth::kLost;
}

} // namespace

Joint BodyBinding::bone_of(const Bound& bound) { return bound.hold ? bound.hold->bone : kPelvis; }

void BodyBinding::bind(const PosedBody& body, std::span<const SE3> nodes) {
  for (std::size_t n = nodes_.size(); n < nodes.size(); ++n) {
    const std::optional<BoneHold> hold = hold_of(body, nodes[n].translation());
    const Joint second = hold ? hold->second : kPelvis;
    nodes_.push_back({hold, body.bones[hold ? hold->bone : kPelvis].inverse() * nodes[n],
                      body.bones[second].inverse() * nodes[n].translation()});
  }
}

void BodyBinding::renew(const Bones& bones, std::span<const SE3> nodes, std::span<const double> seen) {
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    Bound& bound = nodes_[n];
    const double share = kRenewed * seen[n];
    const SE3 now = bones[bone_of(bound)].inverse() * nodes[n];
    const Eigen::Quaterniond turn(bound.beside_bone.linear());
    bound.beside_bone.linear() = turn.slerp(share, Eigen::Quaterniond(now.linear())).toRotationMatrix();
    bound.beside_bone.translation() += share * (now.translation() - bound.beside_bone.translation());
    if (!bound.hold) continue;
    bound.beside_second += share * (bones[bound.hold->second].inverse() * nodes[n].translation() - bound.beside_second);
  }
}

void BodyBinding::turn_back(std::span<const Eigen::Quaterniond> before) {
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    nodes_[n].beside_bone.linear() = nodes_[n].beside_bone.linear() * before[n].conjugate().toRotationMatrix();
  }
}

std::optional<Eigen::Vector3d> BodyBinding::place_of(std::size_t node, const Bones& bones) const {
  const Bound& bound = nodes_.at(node);
  if (!bound.hold) return std::nullopt;
  return bound.hold->weight * (bones[bound.hold->bone] * bound.beside_bone.translation()) +
         (1 - bound.hold->weight) * (bones[bound.hold->second] * bound.beside_second);
}

std::optional<Limb> BodyBinding::limb_of(std::size_t node) const {
  if (node >= nodes_.size() || !nodes_[node].hold) return std::nullopt;
  return tracking::limb_of(nodes_[node].hold->bone);
}

std::vector<SE3> BodyBinding::placed(const Bones& bones) const {
  std::vector<SE3> result;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    result.emplace_back(bones[bone_of(nodes_[n])] * nodes_[n].beside_bone);
    if (const auto place = place_of(n, bones)) result.back().translation() = *place;
  }
  return result;
}

std::vector<NodePull> BodyBinding::pulls(const Bones& bones, const std::array<LimbHealth, kLimbs>& limbs,
                                         const SE3& from_world, double sigma) const {
  std::vector<NodePull> result(nodes_.size());
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (!nodes_[n].hold || is_lost(nodes_[n].hold->bone, limbs)) continue;
    result[n] = {from_world * *place_of(n, bones), 1 / sigma};
  }
  return result;
}

} // namespace kinora::tracking
