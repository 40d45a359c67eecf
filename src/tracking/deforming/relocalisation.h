// Where a deforming layer may be that is not where it is expected, or was lost and is seen again: anywhere in the view,
// as its bones have it, or bent and turned as in some frame before. Bones tell that of people; the frames before tell
// it of everything.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tracking/deforming/model_in_view.h"
#include "tracking/deforming/node_trajectory.h"
#include "tracking/deforming/pose_database.h"

namespace kinora::tracking {

struct RelocalisationConfig {
  std::size_t max_ranked_points = 1000; ///< of the surface, that rank the poses
  std::size_t max_aligned_poses = 3;
};

/// Not thread-safe. Same calls, same bits, for any number of threads.
class Relocalisation {
public:
  explicit Relocalisation(const RelocalisationConfig& config = {}) : config_(config) {}

  /// A frame of the trajectory in which the layer was tracked well.
  void add(std::size_t frame, const SE3& origin_to_camera, const NodeTrajectory& trajectory);
  /// What is remembered in the canonical pose that the trajectory has now.
  void set_canonical_pose(const NodeTrajectory& trajectory);

  /// `best`, or what explains the view better: alignment from the rigid motion of `prior` that lies best anywhere in
  /// the view, or from `node_transforms`, where bones have the nodes (may be empty). `selection`: of the prior.
  static DeformingAlignment search(const ModelInView& now, const DeformingSelection& selection,
                                   const motion::NodeStates& prior, std::span<const SE3> node_transforms,
                                   DeformingAlignment best);
  /// `best`, or what explains the view better: alignment from the frames remembered that agree with it most.
  DeformingAlignment relocalise(const ModelInView& now, const NodeTrajectory& trajectory,
                                DeformingAlignment best) const;

private:
  std::vector<motion::NodeStates> candidates(const ModelInView& now, const NodeTrajectory& trajectory) const;

  RelocalisationConfig config_;
  PoseDatabase pose_database_;
};

} // namespace kinora::tracking
