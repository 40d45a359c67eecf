#include "tracking/deforming/bone_skinning.h"

#include <algorithm>
#include <limits>

#include "tracking/body/limbs.h"

namespace kinora::tracking {
namespace {

constexpr double kUpdateRate = 0.2; // share of what one frame says: bones jitter from frame to frame
constexpr double kMinVisible = 0.5; // of a node that may be bound anew
constexpr double kMinGain = 0.03;   // metres that another bone's surface must be nearer then

bool is_on_lost_limb(Joint bone, const std::array<LimbHealth, kLimbs>& limbs) {
  const std::optional<Limb> limb = limb_of(bone);
  return limb && limbs[*limb] == LimbHealth::kLost;
}

bool is_arm(const std::optional<Limb>& limb) { return limb == kLeftArm || limb == kRightArm; }

// Other bones that a node is clearly nearer to.
std::optional<BoneAttachment> closer_attachment(const PosedBody& body, const std::optional<BoneAttachment>& attachment,
                                                const Eigen::Vector3d& node) {
  const auto distance = [&](Joint bone) { return std::max(0.0, distance_to_bone(body, bone, node)); };
  const double now = attachment ? distance(attachment->bone) : std::numeric_limits<double>::infinity();
  if (now < kMinGain) return std::nullopt;
  const std::optional<BoneAttachment> other = attach_to_bones(body, node);
  return other && distance(other->bone) + kMinGain <= now ? other : std::nullopt;
}

} // namespace

Joint BoneSkinning::anchor_bone(const BoundNode& node_binding) {
  return node_binding.attachment ? node_binding.attachment->bone : kPelvis;
}

BoneSkinning::BoundNode BoneSkinning::bind_node(const PosedBody& body, const std::optional<BoneAttachment>& attachment,
                                                const SE3& node) {
  const Joint second = attachment ? attachment->second : kPelvis;
  return {attachment, body.bones[attachment ? attachment->bone : kPelvis].inverse() * node,
          body.bones[second].inverse() * node.translation()};
}

void BoneSkinning::bind(const PosedBody& body, std::span<const SE3> nodes, std::span<const double> seen) {
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (seen[n] < kMinVisible) continue;
    const std::optional<BoneAttachment> attachment =
        closer_attachment(body, nodes_[n].attachment, nodes[n].translation());
    if (attachment) nodes_[n] = bind_node(body, attachment, nodes[n]);
  }
  for (std::size_t n = nodes_.size(); n < nodes.size(); ++n) {
    nodes_.push_back(bind_node(body, attach_to_bones(body, nodes[n].translation()), nodes[n]));
  }
}

void BoneSkinning::update_offsets(const Bones& bones, std::span<const SE3> nodes, std::span<const double> seen) {
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    BoundNode& node_binding = nodes_[n];
    const double share = kUpdateRate * seen[n];
    const SE3 now = bones[anchor_bone(node_binding)].inverse() * nodes[n];
    const Eigen::Quaterniond rotation(node_binding.in_bone.linear());
    node_binding.in_bone.linear() = rotation.slerp(share, Eigen::Quaterniond(now.linear())).toRotationMatrix();
    node_binding.in_bone.translation() += share * (now.translation() - node_binding.in_bone.translation());
    if (!node_binding.attachment) continue;
    node_binding.in_second_bone += share * (bones[node_binding.attachment->second].inverse() * nodes[n].translation() -
                                            node_binding.in_second_bone);
  }
}

void BoneSkinning::apply_inverse_rotation(std::span<const Eigen::Quaterniond> before) {
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    nodes_[n].in_bone.linear() = nodes_[n].in_bone.linear() * before[n].conjugate().toRotationMatrix();
  }
}

std::optional<Eigen::Vector3d> BoneSkinning::position_of(std::size_t node, const Bones& bones) const {
  const BoundNode& node_binding = nodes_.at(node);
  if (!node_binding.attachment) return std::nullopt;
  return node_binding.attachment->weight * (bones[node_binding.attachment->bone] * node_binding.in_bone.translation()) +
         (1 - node_binding.attachment->weight) * (bones[node_binding.attachment->second] * node_binding.in_second_bone);
}

bool BoneSkinning::are_disconnected(std::size_t a, std::size_t b) const {
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

std::optional<Joint> BoneSkinning::bone_of(std::size_t node) const {
  if (node >= nodes_.size() || !nodes_[node].attachment) return std::nullopt;
  return nodes_[node].attachment->bone;
}

std::optional<Limb> BoneSkinning::limb_of(std::size_t node) const {
  const std::optional<Joint> bone = bone_of(node);
  return bone ? tracking::limb_of(*bone) : std::nullopt;
}

std::vector<SE3> BoneSkinning::node_transforms(const Bones& bones) const {
  std::vector<SE3> result;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    result.emplace_back(bones[anchor_bone(nodes_[n])] * nodes_[n].in_bone);
    if (const auto position = position_of(n, bones)) result.back().translation() = *position;
  }
  return result;
}

std::vector<NodeTarget> BoneSkinning::targets(const Bones& bones, const std::array<LimbHealth, kLimbs>& limbs,
                                              const SE3& from_world, double sigma) const {
  std::vector<NodeTarget> result(nodes_.size());
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (!nodes_[n].attachment || is_on_lost_limb(nodes_[n].attachment->bone, limbs)) continue;
    result[n] = {from_world * *position_of(n, bones), 1 / sigma};
  }
  return result;
}

} // namespace kinora::tracking
