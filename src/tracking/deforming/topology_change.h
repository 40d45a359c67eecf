// Surfaces that touch in canonical space and part: hands that were folded, arms that hung down. Points of one are moved
// by nodes of the other as well, and edges tie what has come apart. The layer then needs another canonical pose, one in
// which these surfaces are apart.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tracking/model/arap_deformation.h"

namespace kinora::tracking {

/// Lengths in units of the nodes' spacing.
struct TopologyChangeConfig {
  double near = 2;            ///< nodes that move the same points
  double apart = 1;           ///< by so much farther away from each other, they no longer do
  double max_stretch = 1.3;   ///< of an edge that holds
  double target_weight = 0.3; ///< of a node towards where it is, against one edge: what is mistaken stands alone
  std::size_t min_pairs = 3;  ///< that part; fewer may be mistaken
  std::size_t min_ratio = 2;  ///< as many pairs part as come together, or else the other pose is no better
};

/// Nodes that are near others in canonical space and apart from them in two frames, one after the other, if the later
/// one's pose would be the better canonical one: few that are apart so far would be near. None if not.
/// `nodes`: canonical, `spacing` metres from each other; `before`, `now`: transforms of the nodes in both frames;
/// `seen`: how much of each node the later one shows; what is hidden proves nothing. Thread-safe.
std::vector<std::size_t> find_separated_nodes(std::span<const Eigen::Vector3d> nodes, double spacing,
                                              std::span<const SE3> before, std::span<const SE3> now,
                                              std::span<const double> seen, const TopologyChangeConfig& config = {});

/// The pose of `now` without what it has stretched, but for edges that tie what has parted: the next canonical pose, as
/// a transform of each node from that so far. Thread-safe.
std::vector<SE3> separated_pose(std::span<const Eigen::Vector3d> nodes, std::span<const GraphEdge> edges,
                                std::span<const SE3> now, const TopologyChangeConfig& config = {});

} // namespace kinora::tracking
