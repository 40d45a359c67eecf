// Finds the labels of a capture as its frames come by, and follows those that move.
#pragma once

#include <map>

#include "core/progress.h"
#include "encode/settings.h"
#include "encode/stage_times.h"
#include "encode/tracked_label.h"
#include "ingest/frame/frame.h"

namespace kinora::encode {

/// What is rigid by default but bends is followed anew as a layer that deforms, from the first frame on that is
/// remembered (tracking::FrameHistory), and without a body. Not thread-safe.
class SceneTracker {
public:
  SceneTracker(const ingest::CaptureInfo& capture, const TrackingSettings& settings, Progress& progress);

  /// The next frame of the timeline. It is followed at about 640 pixels along its longer side.
  void add(const ingest::Frame& frame, StageTimes& times);

  /// All that is followed, as of the last frame.
  const std::map<int, TrackedLabel>& labels() const { return labels_; }

  /// All that was followed, by label in ascending order; it takes the tracker, which can follow nothing more. What was
  /// found late is followed back to where it was before (DeformingTracker::finish).
  std::map<int, TrackedLabel> finish(StageTimes& times) &&;

private:
  struct LabelObservation; ///< what one frame shows of a label
  std::map<int, LabelObservation> observations_in(const ingest::Frame& frame) const;
  void begin_label(int label, const LabelObservation& observation, const ingest::Frame& frame);
  void follow_rigid(TrackedLabel& tracked, const ingest::Frame& frame);
  void make_deforming(TrackedLabel& tracked);

  const ingest::CaptureInfo& capture_;
  TrackingSettings settings_;
  Progress& progress_;
  int frames_ = 0;
  std::map<int, TrackedLabel> labels_;
  std::map<int, std::size_t> first_shown_; ///< frame of each label that was ever shown
  bool warned_of_crowd_ = false;
};

} // namespace kinora::encode
