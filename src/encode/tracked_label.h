// A label of the capture, and what became of it in all frames.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "encode/layer_plan.h"
#include "motion/joint_paths.h"
#include "motion/motion.h"
#include "tracking/deforming/deforming_tracker.h"
#include "tracking/rigid/rigid_tracker.h"

namespace kinora::encode {

/// One label's plan and what became of it.
struct TrackedLabel {
  LayerPlan plan;
  int first_frame = 0;         ///< of the timeline
  std::size_t pixels = 0;      ///< measured, over all frames
  std::size_t first_shown = 0; ///< the first frame of the timeline that shows a pixel of it, measured or not
  std::size_t last_shown = 0;  ///< the last one so far
  Eigen::Vector3d centre;      ///< of its measured points in the first frame, world
  double radius = 0;           ///< root mean square distance of these points from the centre, metres
  /// One per frame so far, if rigid; if deforming, one per frame before the graph.
  std::vector<motion::Motion::Pose> poses;
  int relocalised = 0;                               ///< times it was found again
  int degenerate_directions = 0;                     ///< summed over frames, of six each: what geometry could not tell
  std::optional<tracking::NonRigidity> non_rigidity; ///< of what was taken for rigid; frames of the timeline
  std::unique_ptr<tracking::RigidTracker> tracker;   ///< if rigid
  std::optional<tracking::MissedObject> missed;      ///< by that in the last frame
  std::unique_ptr<tracking::DeformingTracker> deforming_tracker; ///< if deforming, up to the last frame
  std::optional<tracking::TrackedLayer> layer;                   ///< and after that, unless it was never seen
  std::vector<SE3> world_moves; ///< of all frames, since they were tracked; empty: none

  /// Over the whole timeline, or all of it so far: still if it never left its place by more than tracking can tell.
  motion::Motion motion() const;
  /// The world is moved in each frame of the timeline, and all of the label with it; after the last frame.
  void move_world(const std::vector<SE3>& moves);
  /// Of its skeleton over the whole timeline, if it is a person.
  std::optional<motion::JointPaths> joints() const;
  /// Greatest distance (metres) of its points from where they were in its first frame; only if rigid.
  double max_displacement() const;
};

} // namespace kinora::encode
