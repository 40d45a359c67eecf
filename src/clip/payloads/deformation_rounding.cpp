#include "clip/payloads/deformation_rounding.h"

#include "motion/skinning/blended_motion.h"

namespace kinora::clip {

namespace {

bool same(const DualQuaternion& a, const DualQuaternion& b) {
  return a.real.coeffs() == b.real.coeffs() && a.dual.coeffs() == b.dual.coeffs();
}

} // namespace

DeformationRounding::DeformationRounding(const motion::DeformationGraph& graph) {
  const auto add = [&](const Eigen::Vector3d& canonical) {
    const motion::Influence influence = graph.influence(canonical);
    if (influence.count > 0) points_.push_back({canonical, influence});
  };
  for (const Eigen::Vector3d& node : graph.nodes()) {
    add(node);
    for (int a = 0; a < 3; ++a) {
      add(node - graph.weight_radius() * Eigen::Vector3d::Unit(a));
      add(node + graph.weight_radius() * Eigen::Vector3d::Unit(a));
    }
  }
}

std::vector<NodeState> DeformationRounding::rounded(std::span<const DualQuaternion> node_to_world,
                                                    std::span<const RestPosition> rest) const {
  std::vector<NodeState> nodes(rest.size());
  std::vector<DualQuaternion> kept(rest.size());
  const auto keep = [&](std::size_t i, const NodeSteps& steps) {
    nodes[i] = quantise(node_to_world[i], rest[i], steps);
    kept[i] = dequantise(nodes[i], rest[i]);
  };
  bool stored_before = true;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    keep(i, kFineSteps);
    stored_before = stored_before && same(kept[i], node_to_world[i]);
  }
  if (stored_before) return nodes;
  for (std::size_t i = 0; i < rest.size(); ++i) keep(i, kCoarseSteps);
  std::vector<Eigen::Vector3d> wanted(points_.size());
  for (std::size_t p = 0; p < points_.size(); ++p) {
    wanted[p] = motion::blend_motion(node_to_world, points_[p].influence).apply(points_[p].canonical);
  }
  // Until nothing is left to do: finer nodes may bring a point that was near enough a little farther.
  std::vector<bool> fine(rest.size(), false);
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t p = 0; p < points_.size(); ++p) {
      const auto& [canonical, influence] = points_[p];
      for (int k = 0; k < influence.count; ++k) { // the heaviest first
        const Eigen::Vector3d moved = motion::blend_motion(kept, influence).apply(canonical);
        if ((moved - wanted[p]).norm() <= kLargestMotionError) break;
        const auto i = static_cast<std::size_t>(influence.nodes[static_cast<std::size_t>(k)]);
        if (fine[i]) continue;
        fine[i] = true;
        changed = true;
        keep(i, kFineSteps);
      }
    }
  }
  return nodes;
}

} // namespace kinora::clip
