#include "tracking/brick_influences.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/parallel.h"
#include "tracking/node_candidates.h"

namespace kinora::tracking {

void BrickInfluences::renew(const TsdfVolume& volume, std::shared_ptr<const DeformationGraph> graph) {
  constexpr std::size_t kBricksPerChunk = 64;
  const std::vector<Eigen::Vector3d>& nodes = graph->nodes();
  const std::span added = std::span(nodes).subspan(graph_ ? graph_->nodes().size() : 0);
  const std::size_t old = candidates_.size();
  graph_ = std::move(graph);
  candidates_.resize(volume.brick_count());
  revisions_.resize(volume.brick_count(), 0);
  for (const Eigen::Vector3d& node : added) {
    for (const double along : {node.x(), node.y(), node.z(), 0.0}) positions_.push_back(static_cast<float>(along));
  }
  if (added.empty() && old == candidates_.size()) return;
  const double side = volume.brick_size();
  const double reach = graph_->influence_radius() + std::sqrt(3.0) * side; // more than is needed
  const NodeCandidates search(*graph_, side);
  parallel_for(candidates_.size(), kBricksPerChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const Eigen::Vector3d centre = volume.brick_centre(i);
      const auto is_near = [&](const Eigen::Vector3d& node) { return (node - centre).squaredNorm() < reach * reach; };
      if (i < old && std::none_of(added.begin(), added.end(), is_near)) continue;
      candidates_[i].clear();
      search.append(centre, candidates_[i]);
      ++revisions_[i];
    }
  });
}

void BrickInfluences::weigh(std::size_t brick, const PointLanes& points, InfluenceLanes& influences) const {
  if (brick < candidates_.size()) {
    weigh_nodes({candidates_[brick], positions_.data(), static_cast<float>(graph_->influence_radius()),
                 static_cast<float>(graph_->weight_radius())},
                points, influences);
    return;
  }
  for (std::size_t i = 0; i < PointLanes::kPoints; ++i) {
    influences.set(i, graph_->influence(points.at(i).cast<double>()));
  }
}

} // namespace kinora::tracking
