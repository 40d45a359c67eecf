#include "tracking/deforming/body_binding.h"

#include <algorithm>
#include <limits>

#include "tracking/body/limbs.h"

namespace kinora::tracking {
namespace {

constexpr double kRenewed = 0.2; // share of what one frame says: bones jitter from frame to frame
constexpr double kSeen = 0.5;    // of a node that may be bound anew
constexpr double kNearer = 0.03; // metres that another bone's surface must be nearer then

bool is_lost(Joint bone, const std::array<LimbHealth, kLimbs>& limbs) {
  const std::optional<Limb> limb = limb_of(bone);
  return limb && limbs[*limb] == LimbHealth::kLost;
}

bool is_arm(const std::optional<Limb>& limb) { return limb == kLeftArm || limb == kRightArm; }

// Other bones that a node is clearly nearer to.
std::optional<BoneHold> better_hold(const PosedBody& body, const std::optional<BoneHold>& hold,
                                    const Eigen::Vector3d& node) {
  const auto distance = [&](Joint bone) { return std::max(0.0, distance_to_bone(body, bone, node)); };
  const double now = hold ? distance(hold->bone) : std::numeric_limits<double>::infinity();
  if (now < kNearer) return std::nullopt;
  const std::optional<BoneHold> other = hold_of(body, node);
  return other && distance(other->bone) + kNearer <= now ? other : std::nullopt;
}

} // namespace

Joint BodyBinding::holder_of(const Bound& bound) { return bound.hold ? bound.hold->bone : kPelvis; }

BodyBinding::Bound BodyBinding::bound_to(const PosedBody& body, const std::optional<BoneHold>& hold, const SE3& node) {
  const Joint second = hold ? hold->second : kPelvis;
  return {hold, body.bones[hold ? hold->bone : kPelvis].inverse() * node,
          body.bones[second].inverse() * node.translation()};
}

void BodyBinding::bind(const PosedBody& body, std::span<const SE3> nodes, std::span<const double> seen) {
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (seen[n] < kSeen) continue;
    const std::optional<BoneHold> hold = better_hold(body, nodes_[n].hold, nodes[n].translation());
    if (hold) nodes_[n] = bound_to(body, hold, nodes[n]);
  }
  for (std::size_t n = nodes_.size(); n < nodes.size(); ++n) {
    nodes_.push_back(bound_to(body, hold_of(body, nodes[n].translation()), nodes[n]));
  }
}

void BodyBinding::renew(const Bones& bones, std::span<const SE3> nodes, std::span<const double> seen) {
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    Bound& bound = nodes_[n];
    const double share = kRenewed * seen[n];
    const SE3 now = bones[holder_of(bound)].inverse() * nodes[n];
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

bool BodyBinding::are_apart(std::size_t a, std::size_t b) const {
  const std::optional<Joint> bone_a = bone_of(a);
  const std::optional<Joint> bone_b = bone_of(b);
  if (!bone_a || !bone_b) return false;
  const std::optional<Limb> limb_a = tracking::limb_of(*bone_a);
  const std::optional<Limb> limb_b = tracking::limb_of(*bone_b);
  if (limb_a == limb_b) return false;
  if (limb_a && limb_b) return is_arm(limb_a) || is_arm(limb_b);
  const Limb limb = limb_a ? *limb_a : *limb_b; // the other is of the trunk
  return is_arm(limb) && *(limb_a ? bone_a : bone_b) != chain_of(limb).ball;
}

std::optional<Joint> BodyBinding::bone_of(std::size_t node) const {
  if (node >= nodes_.size() || !nodes_[node].hold) return std::nullopt;
  return nodes_[node].hold->bone;
}

std::optional<Limb> BodyBinding::limb_of(std::size_t node) const {
  const std::optional<Joint> bone = bone_of(node);
  return bone ? tracking::limb_of(*bone) : std::nullopt;
}

std::vector<SE3> BodyBinding::placed(const Bones& bones) const {
  std::vector<SE3> result;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    result.emplace_back(bones[holder_of(nodes_[n])] * nodes_[n].beside_bone);
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
