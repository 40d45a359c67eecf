// Where limbs are when a frame comes in: a hand that hits out, or stops, is not where its own velocity leads to. Bones,
// which are searched for limbs (limb_search.h), say where else to begin, and the view decides.
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "tracking/deforming_tracker.h"

namespace kinora::tracking {
void DeformingTracker::place_limbs(const ObjectView& view, const SE3& world_to_camera, std::vector<SE3>& nodes) const {
  const std::vector<SE3> placed = placed_by_bones();
  if (placed.empty()) return;
  for (const Limb limb : kEveryLimb) {
    const LimbChain& chain = chain_of(limb);
    const std::array bones = {chain.ball, chain.hinge, chain.end};
    for (std::size_t first = 0; first < bones.size(); ++first) {
      place_bones(std::span(bones).subspan(first), placed, view, world_to_camera, nodes);
    }
  }
}

// `placed`: where the bones have all nodes.
void DeformingTracker::place_bones(std::span<const Joint> bones, std::span<const SE3> placed, const ObjectView& view,
                                   const SE3& world_to_camera, std::vector<SE3>& nodes) const {
  std::vector<SE3> moved = nodes;
  std::vector<std::uint8_t> is_moved(nodes.size(), 0);
  double apart = 0;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const std::optional<Joint> bone = body_.bone_of(n);
    if (!bone || std::find(bones.begin(), bones.end(), *bone) == bones.end()) continue;
    is_moved[n] = 1;
    moved[n] = placed[n];
    apart = std::max(apart, (placed[n] * nodes_[n] - nodes[n] * nodes_[n]).norm());
  }
  if (apart < config_.limbs.distance) return;
  const auto goes_along = [&](const Influence& influence) {
    double weight = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
      if (is_moved[static_cast<std::size_t>(influence.nodes[k])] != 0) weight += influence.weights[k];
    }
    return weight > config_.limbs.weight_share;
  };
  const double before = shown_share(view, states_in(world_to_camera, nodes), goes_along);
  const double after = shown_share(view, states_in(world_to_camera, moved), goes_along);
  // What is mostly seen where it is expected is not far from there, in metres: a skirt, when legs move under it.
  if (after > before + config_.limbs.clearly_better + before * apart) nodes = std::move(moved);
}

} // namespace kinora::tracking
