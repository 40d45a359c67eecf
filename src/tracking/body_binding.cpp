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

void BodyBinding::bind(const PosedBody& body, std::span<const Eigen::Vector3d> places) {
  for (std::size_t n = nodes_.size(); n < places.size(); ++n) {
    nodes_.emplace_back();
    const std::optional<BoneHold> hold = hold_of(body, places[n]);
    if (!hold) continue;
    nodes_.back() =
        Bound{*hold, body.bones[hold->bone].inverse() * places[n], body.bones[hold->second].inverse() * places[n]};
  }
}

void BodyBinding::renew(const Bones& bones, std::span<const Eigen::Vector3d> places, std::span<const double> seen) {
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (!nodes_[n]) continue;
    Bound& bound = *nodes_[n];
    const double share = kRenewed * seen[n];
    bound.beside_bone += share * (bones[bound.hold.bone].inverse() * places[n] - bound.beside_bone);
    bound.beside_second += share * (bones[bound.hold.second].inverse() * places[n] - bound.beside_second);
  }
}

std::optional<Eigen::Vector3d> BodyBinding::place_of(std::size_t node, const Bones& bones) const {
  if (!nodes_.at(node)) return std::nullopt;
  const Bound& bound = *nodes_[node];
  return bound.hold.weight * (bones[bound.hold.bone] * bound.beside_bone) +
         (1 - bound.hold.weight) * (bones[bound.hold.second] * bound.beside_second);
}

std::vector<SE3> BodyBinding::carried(const Bones& before, const Bones& now) const {
  std::vector<SE3> result;
  for (const std::optional<Bound>& bound : nodes_) {
    const Joint bone = bound ? bound->hold.bone : kPelvis;
    result.emplace_back(now[bone] * before[bone].inverse());
  }
  return result;
}

std::vector<NodePull> BodyBinding::pulls(const Bones& bones, const std::array<LimbHealth, kLimbs>& limbs,
                                         const SE3& from_world, double sigma) const {
  std::vector<NodePull> result(nodes_.size());
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (!nodes_[n] || is_lost(nodes_[n]->hold.bone, limbs)) continue;
    result[n] = {from_world * *place_of(n, bones), 1 / sigma};
  }
  return result;
}

} // namespace kinora::tracking
