#include "motion/warp.h"

#include <array>

#include "core/error.h"
#include "motion/skinning/blended_motion.h"

namespace kinora::motion {

Warp::Warp(std::shared_ptr<const DeformationGraph> graph, std::vector<DualQuaternion> node_to_world) {
  if (graph == nullptr || graph->nodes().size() != node_to_world.size()) {
    throw Error(ErrorCode::kFailure, "a deforming warp needs one transform for each node of its graph");
  }
  Live live;
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t i = 0; i < node_to_world.size(); ++i) {
    const SE3 transform = node_to_world[i].to_se3();
    positions.emplace_back(transform * graph->nodes()[i]);
    live.world_to_node.push_back(transform.inverse());
  }
  live.nearest = NearestPoints(positions, graph->influence_radius());
  live.graph = std::move(graph);
  live.node_to_world = std::move(node_to_world);
  live_ = std::make_shared<const Live>(std::move(live));
}

const std::vector<Eigen::Vector3d>& Warp::node_positions() const {
  static const std::vector<Eigen::Vector3d> kNone;
  return live_ ? live_->nearest.points() : kNone;
}

const std::vector<DualQuaternion>& Warp::node_to_world() const {
  static const std::vector<DualQuaternion> kNone;
  return live_ ? live_->node_to_world : kNone;
}

std::size_t Warp::nearest_nodes(const Eigen::Vector3d& world, std::span<NearestPoints::Neighbour> found) const {
  return live_ ? live_->nearest.find(world, found) : 0;
}

SE3 Warp::at(const Influence& influence) const {
  return blend_motion(live_->node_to_world, influence).transform.to_se3();
}

std::optional<SE3> Warp::at(const Eigen::Vector3d& canonical) const {
  if (is_rigid()) return rigid_;
  const Influence influence = live_->graph->influence(canonical);
  if (influence.count == 0) return std::nullopt;
  return at(influence);
}

std::optional<Eigen::Vector3d> Warp::to_world(const Eigen::Vector3d& canonical) const {
  const auto transform = at(canonical);
  if (!transform) return std::nullopt;
  return *transform * canonical;
}

std::optional<Eigen::Vector3d> Warp::to_canonical(const Eigen::Vector3d& world) const {
  if (is_rigid()) return rigid_.inverse() * world;
  constexpr std::size_t kStarts = 4;
  constexpr int kSteps = 8;
  constexpr double kTolerance = 1e-4; // metres
  std::array<NearestPoints::Neighbour, kStarts> starts{};
  const std::size_t count = nearest_nodes(world, starts);
  for (std::size_t s = 0; s < count; ++s) {
    Eigen::Vector3d canonical = live_->world_to_node[static_cast<std::size_t>(starts[s].index)] * world;
    // Fixed point: the warp's derivative is close to its rotation.
    for (int step = 0; step < kSteps; ++step) {
      const auto transform = at(canonical);
      if (!transform) break;
      const Eigen::Vector3d miss = world - *transform * canonical;
      if (miss.squaredNorm() < kTolerance * kTolerance) return canonical;
      canonical += transform->linear().transpose() * miss;
    }
  }
  return std::nullopt;
}

} // namespace kinora::motion
