#include "tracking/model/brick_influences.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/parallel.h"
#include "motion/skinning/node_candidates.h"

namespace kinora::tracking {

void BrickInfluences::update(const TsdfVolume& volume, std::shared_ptr<const motion::DeformationGraph> graph) {
  constexpr std::size_t kBricksPerChunk = 64;
  const std::vector<Eigen::Vector3d>& nodes = graph->nodes();
  const std::span added = std::span(nodes).subspan(graph_ ? graph_->nodes().size() : 0);
  const std::size_t old = candidates_.size();
  graph_ = std::move(graph);
  candidates_.resize(volume.brick_count());
  revisions_.resize(volume.brick_count(), 0);
  for (const Eigen::Vector3d& node : added) positions_.push_back(motion::position_row(node));
  if (added.empty() && old == candidates_.size()) return;
  const motion::NodeCandidates search(*graph_, volume.brick_size());
  parallel_for(candidates_.size(), kBricksPerChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const Eigen::Vector3d centre = volume.brick_centre(i);
      std::vector<std::int32_t>& candidates = candidates_[i];
      const std::size_t before = candidates.size();
      if (i >= old || before + added.size() > motion::NodeCandidates::kMax) {
        candidates.clear();
        search.append(centre, candidates);
        ++revisions_[i];
        continue;
      }
      for (std::size_t n = nodes.size() - added.size(); n < nodes.size(); ++n) {
        const auto node = static_cast<std::int32_t>(n);
        if (search.is_new_candidate(centre, node, candidates)) candidates.push_back(node);
      }
      if (candidates.size() > before) ++revisions_[i];
    }
  });
}

void BrickInfluences::skinning_weights_of(std::size_t brick, const motion::PointLanes& points,
                                          motion::InfluenceLanes& influences) const {
  if (brick < candidates_.size()) {
    motion::skinning_weights({candidates_[brick], positions_.data(), static_cast<float>(graph_->influence_radius()),
                              static_cast<float>(graph_->weight_radius())},
                             points, influences);
    return;
  }
  for (std::size_t i = 0; i < motion::PointLanes::kPoints; ++i) {
    influences.set(i, graph_->influence(points.at(i).cast<double>()));
  }
}

} // namespace kinora::tracking
