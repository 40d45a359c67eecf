// Which nodes may move some point of a cube of canonical space: found once for many points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "motion/skinning/deformation_graph.h"

namespace kinora::motion {

/// Finds, for cubes of one size, the nodes that are among the nearest of some point: all but those to which enough
/// others are nearer everywhere. One more than have a say: the first that has none has its part in the weights.
/// Immutable, thread-safe.
class NodeCandidates {
public:
  /// Of a cube at most; of more, the nearest to its centre are kept.
  static constexpr std::size_t kMax = 255;

  /// `side` of the cubes, metres.
  NodeCandidates(const DeformationGraph& graph, double side);
  /// Appends those of the cube about `centre`, nearest to it first.
  void append(const Eigen::Vector3d& centre, std::vector<std::int32_t>& candidates) const;
  /// Whether a node must join a cube's candidates, among which it is not: one that the graph has got since.
  bool is_new_candidate(const Eigen::Vector3d& centre, std::int32_t node,
                        std::span<const std::int32_t> candidates) const;

private:
  bool is_too_far(const NearestPoints::Neighbour& last, const NearestPoints::Neighbour& node) const;

  double side_;
  double half_diagonal_;
  double reach_; ///< of a node, from a cube's centre
  NearestPoints nearest_;
};

} // namespace kinora::motion
