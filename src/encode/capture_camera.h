// Where the capture's camera is: as the capture says, or as the background shows.
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "encode/stage_times.h"
#include "tracking/camera_tracker.h"

namespace kinora::encode {

/// Not thread-safe.
class CaptureCamera {
public:
  /// `has_poses`: the frames bring their poses.
  explicit CaptureCamera(bool has_poses) : has_poses_(has_poses) {}

  /// Gives the next frame of the timeline its pose, before anything else looks at it.
  void place(ingest::Frame& frame, StageTimes& times);

  /// Camera to world after the last frame: one pose per frame, or one for all if the camera never moved.
  std::vector<SE3> path() const;
  /// For each frame what carries the world that it was given into the world of path(): near the identity, and all the
  /// identity if nothing was learned later. Empty if the camera is still or brings its poses.
  std::vector<SE3> corrections() const;
  /// "path" (moving or still), "why", and how it was followed.
  nlohmann::json json() const;

private:
  bool has_poses_;
  std::vector<SE3> given_; ///< camera to world of each frame so far
  tracking::CameraTracker tracker_;
};

} // namespace kinora::encode
