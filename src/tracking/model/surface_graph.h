// Which nodes of a deformation graph hold each other: those that are near along the surface.
// Source: Li et al., "Robust Single-View Geometry and Motion Reconstruction", SIGGRAPH Asia 2009.
#pragma once

#include <span>
#include <vector>

#include "motion/skinning/deformation_graph.h"
#include "tracking/model/node_sampling.h"

namespace kinora::tracking {

struct GraphEdge {
  int a, b; ///< a < b
};

struct EdgeConfig {
  std::size_t neighbours = 8;
  double max_detour = 1.6; ///< path along the surface over the straight distance; beyond, the edge is left out
  double reach = 3;        ///< of a path along the surface, in units of the spacing
};

/// Edges between nodes that are near along the surface. A piece that hangs together with nothing else is tied to the
/// straight-line nearest nodes of the rest, so that it follows when nothing of it is seen.
class SurfaceEdges {
public:
  /// `nodes`: those of the last call, and further ones, all in canonical space, `spacing` metres apart. New ones, and
  /// old ones within edges' reach of them, get their edges from the surface's `samples`, which are wanted within twice
  /// that reach of new nodes. `sample_spacing`: the grid cell of downsample_surface. Same bits for any number of
  /// threads.
  void extend(std::span<const Eigen::Vector3d> nodes, std::span<const SurfaceSample> samples, double spacing,
              double sample_spacing, const EdgeConfig& config = {});
  const std::vector<GraphEdge>& edges() const { return edges_; }

private:
  std::vector<std::vector<int>> neighbours_; ///< that each node has found
  std::vector<GraphEdge> edges_;             ///< and those that tie pieces
};

} // namespace kinora::tracking
