// Finds the labels of a capture as its frames come by, and follows those that move.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/progress.h"
#include "encode/layer_plan.h"
#include "encode/settings.h"
#include "encode/stage_times.h"
#include "ingest/frame.h"
#include "tracking/deforming_tracker.h"
#include "tracking/rigid_tracker.h"

namespace kinora::encode {

/// One label's plan and what became of it.
struct TrackedLabel {
  LayerPlan plan;
  int first_frame = 0;    ///< of the timeline
  std::size_t pixels = 0; ///< measured, over all frames
  Eigen::Vector3d centre; ///< of its measured points in the first frame, world
  double radius = 0;      ///< root mean square distance of these points from the centre, metres
  /// One per frame so far, if rigid; if deforming, one per frame before the graph.
  std::vector<tracking::Motion::Pose> poses;
  int relocalised = 0;                             ///< times it was found again
  int weak_directions = 0;                         ///< summed over frames, of six each: what geometry could not tell
  std::optional<tracking::Bend> bend;              ///< of what was taken for rigid; frames of the timeline
  std::unique_ptr<tracking::RigidTracker> tracker; ///< if rigid
  std::unique_ptr<tracking::DeformingTracker> bending; ///< if deforming
};

/// What is rigid by default but bends is followed anew as a layer that deforms, from the first frame on that is
/// remembered (tracking::FrameMemory), and without a body. Not thread-safe.
class SceneTracker {
public:
  SceneTracker(const ingest::CaptureInfo& capture, const TrackingSettings& settings, Progress& progress);

  /// The next frame of the timeline.
  void add(const ingest::Frame& frame, StageTimes& times);

  /// After the last frame: what was found late is followed back to where it was before (DeformingTracker::settle_past).
  void finish(StageTimes& times);

  /// By label, in ascending order.
  const std::map<int, TrackedLabel>& labels() const { return labels_; }
  /// The label's motion over the whole timeline: still if it never left its place by more than tracking can tell.
  tracking::Motion motion_of(const TrackedLabel& label) const;
  /// Of the label's skeleton over the whole timeline, if it is a person.
  std::optional<tracking::JointPaths> joints_of(const TrackedLabel& label) const;
  /// Greatest distance (metres) of the label's points from where they were in its first frame; only if rigid.
  static double largest_move(const TrackedLabel& label);

private:
  struct Sight; ///< what one frame shows of a label
  std::map<int, Sight> sights_in(const ingest::Frame& frame) const;
  void begin_label(int label, const Sight& sight, const ingest::Frame& frame);
  void follow_rigid(TrackedLabel& tracked, const ingest::Frame& frame);
  void let_bend(TrackedLabel& tracked);

  const ingest::CaptureInfo& capture_;
  TrackingSettings settings_;
  Progress& progress_;
  int frames_ = 0;
  std::map<int, TrackedLabel> labels_;
  bool warned_of_crowd_ = false;
};

} // namespace kinora::encode
