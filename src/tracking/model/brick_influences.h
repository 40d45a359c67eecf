// What moves the points of a volume's bricks: a brick keeps the nodes that are in question for its points, so that
// each weighs a dozen nodes instead of searching for them.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "motion/skinning/deformation_graph.h"
#include "motion/skinning/skinned_lanes.h"
#include "tracking/tsdf/tsdf.h"

namespace kinora::tracking {

/// Thread-safe to read; update() needs exclusive use.
class BrickInfluences {
public:
  /// Takes in bricks and nodes that volume and graph have got since the last call: both only ever grow. `graph`: over
  /// canonical space relative to the volume's origin. Same bits for any number of threads.
  void update(const TsdfVolume& volume, std::shared_ptr<const motion::DeformationGraph> graph);

  /// As DeformationGraph::influence at places of that brick (metres, relative to the volume's origin), in single
  /// precision; a brick that is newer than the last renewal may be asked for, too.
  void skinning_weights_of(std::size_t brick, const motion::PointLanes& points,
                           motion::InfluenceLanes& influences) const;
  /// Another number after a renewal that has changed what skinning_weights_of() says of that brick.
  std::uint32_t revision(std::size_t brick) const { return brick < revisions_.size() ? revisions_[brick] : 0; }

private:
  std::shared_ptr<const motion::DeformationGraph> graph_;
  std::vector<motion::PositionRow> positions_;        ///< of each node
  std::vector<std::vector<std::int32_t>> candidates_; ///< nodes, of each brick
  std::vector<std::uint32_t> revisions_;
};

} // namespace kinora::tracking
