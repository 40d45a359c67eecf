// Camera poses that agree best with what is known of pairs of them.
// Source: Grisetti et al., "A Tutorial on Graph-Based SLAM", IEEE ITS Magazine 2(4), 2010.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/se3.h"

namespace kinora::tracking {

/// A measurement of where one camera is as another sees it.
struct PoseEdge {
  std::size_t from, to;
  SE3 to_in_from;    ///< camera `to` → camera `from`
  double weight = 1; ///< of its squared error
};

/// What an edge disagrees by: log(to_in_from⁻¹ · from⁻¹ · to), metres and radians × lever.
Twist edge_error(const PoseEdge& edge, const SE3& from, const SE3& to, double lever);

/// Moves all poses (camera to world) but the first to the least weighted sum of squared edge errors, by Gauss–Newton.
/// `lever` in metres makes rotations lengths: how far away things are that the cameras see. Poses that no edge ties to
/// the first stay where they are. Throws Error(kFailure) for an edge to a pose that does not exist. Thread-safe.
void optimise_poses(std::span<const PoseEdge> edges, double lever, std::vector<SE3>& camera_to_world);

} // namespace kinora::tracking
