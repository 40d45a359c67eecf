#include "tracking/deforming/pose_prediction.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace kinora::tracking {
namespace {

// Who jumps as a whole is where the middle of what is measured has gone.
void initialise_translation(const ModelInView& now, const TrackedView& before, std::span<const SE3> last,
                            const PosePredictionConfig& config, std::vector<SE3>& nodes) {
  const std::vector<Eigen::Vector3d>& canonical = now.model().nodes();
  Eigen::Vector3d step = Eigen::Vector3d::Zero();
  for (std::size_t n = 0; n < nodes.size(); ++n) step += nodes[n] * canonical[n] - last[n] * canonical[n];
  step /= static_cast<double>(nodes.size());
  const Eigen::Vector3d jump = now.origin_to_camera().inverse() * now.view().centroid -
                               before.origin_to_camera.inverse() * before.view.centroid - step;
  if (jump.norm() < config.jump) return;
  std::vector<SE3> moved = nodes;
  for (SE3& node : moved) node.translation() += jump;
  if (now.facing_inlier_share(now.states(moved)) > now.facing_inlier_share(now.states(nodes)) + config.min_share_gain) {
    nodes = std::move(moved);
  }
}

// `node_transforms`: where the bones have all nodes.
void forward_kinematics(const ModelInView& now, const LayerBody& body, std::span<const Joint> bones,
                        std::span<const SE3> node_transforms, const LimbInitialisationConfig& config,
                        std::vector<SE3>& nodes) {
  const std::vector<Eigen::Vector3d>& canonical = now.model().nodes();
  std::vector<SE3> moved = nodes;
  std::vector<std::uint8_t> is_moved(nodes.size(), 0);
  double apart = 0;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const std::optional<Joint> bone = body.bone_of(n);
    if (!bone || std::find(bones.begin(), bones.end(), *bone) == bones.end()) continue;
    is_moved[n] = 1;
    moved[n] = node_transforms[n];
    apart = std::max(apart, (node_transforms[n] * canonical[n] - nodes[n] * canonical[n]).norm());
  }
  if (apart < config.distance) return;
  const auto moves_with_bones = [&](const motion::Influence& influence) {
    double weight = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
      if (is_moved[static_cast<std::size_t>(influence.nodes[k])] != 0) weight += influence.weights[k];
    }
    return weight > config.weight_share;
  };
  const double before = now.facing_inlier_share(now.states(nodes), moves_with_bones);
  const double after = now.facing_inlier_share(now.states(moved), moves_with_bones);
  // What is mostly seen where it is expected is not far from there, in metres: a skirt, when legs move under it.
  if (after > before + config.min_share_gain + before * apart) nodes = std::move(moved);
}

// A hand that hits out, or stops, is not where its own velocity leads to. Bones, which are searched for limbs
// (limb_search.h), say where else to begin, and the view decides.
void initialise_limbs(const ModelInView& now, const LayerBody& body, std::span<const SE3> node_transforms,
                      const LimbInitialisationConfig& config, std::vector<SE3>& nodes) {
  if (node_transforms.empty()) return;
  for (const Limb limb : kEveryLimb) {
    const LimbChain& chain = chain_of(limb);
    const std::array bones = {chain.ball, chain.hinge, chain.end};
    for (std::size_t first = 0; first < bones.size(); ++first) {
      forward_kinematics(now, body, std::span(bones).subspan(first), node_transforms, config, nodes);
    }
  }
}

// Nodes whose texture is elsewhere than they are expected go there.
void apply_block_matching(const ModelInView& now, const TrackedView& before, std::span<const SE3> last,
                          const BlockMatchingConfig& config, std::vector<SE3>& nodes) {
  const motion::NodeStates then = now.model().states(before.origin_to_camera, last);
  const auto flow = match_blocks(before.view, then, now.view(), now.states(nodes), now.model().edges(), config);
  const Eigen::Matrix3d to_world = now.origin_to_camera().linear().transpose();
  for (std::size_t n = 0; n < nodes.size(); ++n) nodes[n].translation() += to_world * flow[n];
}

} // namespace

std::vector<SE3> corrected_prediction(const ModelInView& now, const TrackedView& before, std::span<const SE3> last,
                                      const LayerBinding& binding, std::size_t frame, std::vector<SE3> expected,
                                      const PosePredictionConfig& config) {
  initialise_translation(now, before, last, config, expected);
  initialise_limbs(now, binding.body(), binding.bone_driven_nodes(now.model(), frame), config.limbs, expected);
  apply_block_matching(now, before, last, config.flow, expected);
  return expected;
}

} // namespace kinora::tracking
