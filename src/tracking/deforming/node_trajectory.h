// Where the nodes of a deforming layer were in every frame from the first that showed it.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/se3.h"
#include "motion/motion.h"
#include "tracking/deforming/graph_growth.h"

namespace kinora::tracking {

/// Frames are counted from the capture's first one, which may be before the layer's. Nodes go from canonical space to
/// world, both relative to the layer's origin, metres. Not thread-safe.
class NodeTrajectory {
public:
  struct Frame {
    std::vector<SE3> nodes;
    motion::Health health = motion::Health::kTracked;
    double time = 0; ///< seconds
  };

  /// Begins with frame `first`, which shows `nodes` nodes where they are in canonical space.
  NodeTrajectory(std::size_t first, std::size_t nodes, double time);

  /// The first frame that has nodes, and the number of frames, those before it included.
  std::size_t first() const { return first_; }
  std::size_t frame_count() const { return first_ + frames_.size(); }
  /// first() ≤ `frame` < frame_count().
  const Frame& at(std::size_t frame) const { return frames_[frame - first_]; }
  const Frame& last() const { return frames_.back(); }

  /// The next frame, in which the nodes were found.
  void add_tracked(std::vector<SE3> nodes, double time);
  /// The next frame, in which they were not: they stay where they are. `health`: kHeld or kLost.
  void add_untracked(motion::Health health, double time);

  /// Where the nodes, which are at `canonical`, are at a time after the last frame: as in that one, and farther by
  /// `velocity_weight` of the motion that led there if both the last frames were tracked.
  std::vector<SE3> predicted(std::span<const Eigen::Vector3d> canonical, double time, double velocity_weight) const;

  /// Nodes that the last frame has brought, with the past that the nodes so far would have given them: a guess.
  void add_nodes(const GraphGrowth& growth);
  /// From now on what frames before the last say of the node is a guess.
  void mark_past_extrapolated(std::size_t node) { first_observed_[node] = frame_count() - 1; }
  /// Whether nobody saw the node in that frame, nor what stood for it.
  bool is_extrapolated(std::size_t node, std::size_t frame) const { return first_observed_[node] > frame; }
  /// The first frame in which no node is a guess.
  std::size_t first_without_extrapolation() const;
  /// Other nodes for a frame, after a look back.
  void correct(std::size_t frame, std::vector<SE3> nodes) { frames_[frame - first_].nodes = std::move(nodes); }

  /// Another canonical pose, to which `pose` leads each node from that so far; in the world nothing moves.
  void set_canonical_pose(std::span<const SE3> pose);

  /// For all frames, those before the first as lost where the layer was in the first. `origin`: of the layer, world.
  std::vector<motion::Motion::Deformation> deformations(const Eigen::Vector3d& origin) const;

private:
  std::size_t first_;
  std::vector<Frame> frames_;
  std::vector<std::size_t> first_observed_; ///< for each node, the first frame in which it is not a guess
};

} // namespace kinora::tracking
