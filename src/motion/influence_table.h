// Which nodes may move the points of each canonical cell: found once for a graph, so that a point weighs a dozen nodes
// instead of searching for them.
// Source: the look-up table of Jiang et al., "Instant-NVR", CVPR 2023, sec. 4.2; here a cell keeps every node that can
// be among the nearest of any of its points, so that weights are those of DeformationGraph::influence.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "motion/skinning/deformation_graph.h"
#include "motion/skinning/node_rows.h"

namespace kinora::motion {

/// Immutable, thread-safe. Coordinates are relative to `origin()`, so that single precision does for layers that are
/// far away.
class InfluenceTable {
public:
  /// `graph` must not be null. Uses all threads; same bits for any number of them.
  explicit InfluenceTable(std::shared_ptr<const DeformationGraph> graph);

  const DeformationGraph& graph() const { return *graph_; }
  /// Middle of the nodes, in canonical space.
  const Eigen::Vector3d& origin() const { return origin_; }

  /// What the kernels read (bulk_warp_kernels.h).
  struct Cells {
    std::array<float, 3> low{}; ///< the grid's corner
    float per_metre = 1;        ///< cells
    std::array<std::int32_t, 3> count{};
    std::vector<std::int32_t> begin;      ///< per cell, x fastest, into candidates; one more at the end
    std::vector<std::int32_t> candidates; ///< nodes, nearest to the cell's centre first
    std::vector<PositionRow> positions;   ///< of each node
    float squared_influence_radius = 0;
    float inverse_squared_weight_radius = 0;
  };
  const Cells& cells() const { return cells_; }

private:
  void find_candidates(const Eigen::Vector3d& low, double side);

  std::shared_ptr<const DeformationGraph> graph_;
  Eigen::Vector3d origin_;
  Cells cells_;
};

} // namespace kinora::motion
