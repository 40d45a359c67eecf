// What happens to every frame as it comes, live or not: it gets its place on the timeline, and what it shows is
// followed.
#pragma once

#include <cstddef>
#include <map>

#include "clip/clip.h"
#include "encode/encode_options.h"
#include "encode/scene_tracker.h"
#include "ingest/calibration/stream_delay.h"

namespace kinora::encode {

/// Not thread-safe. Same frames, same bits, for any number of threads.
class FrontEnd {
public:
  /// The capture's description must outlive it.
  FrontEnd(const ingest::CaptureInfo& info, const EncodeOptions& options, Progress& progress);

  /// The next frame. False if it has no mask, unlike others: it is not to be trained on, which is warned of.
  bool add(const ingest::Frame& frame, bool held_out, StageTimes& times);

  /// Timeline, camera and its path; no layer.
  const clip::Clip& timeline() const { return clip_; }
  /// As of the last frame.
  const std::map<int, TrackedLabel>& labels() const { return scene_.labels(); }
  std::optional<double> depth_delay() const { return delay_.seconds(); } ///< seconds (ingest::StreamDelay)
  std::size_t unlabelled() const { return unlabelled_; } ///< frames without mask in a capture with masks

  /// SceneTracker::finish.
  std::map<int, TrackedLabel> finish(StageTimes& times) && { return std::move(scene_).finish(times); }

private:
  const ingest::CaptureInfo& info_;
  Progress& progress_;
  SceneTracker scene_;
  ingest::StreamDelay delay_;
  clip::Clip clip_;
  std::size_t unlabelled_ = 0;
};

} // namespace kinora::encode
