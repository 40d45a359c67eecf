// Where the camera of a capture without poses was, frame by frame, as the background shows.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>

#include "encode/stage_times.h"
#include "ingest/capture/capture.h"
#include "tracking/camera/camera_tracker.h"

namespace kinora::encode {

/// Plain data.
struct CameraPath {
  enum class Origin {
    kNotFollowed, ///< nobody looked, or the capture brings poses
    kFollowed,
    kNothingBetter ///< still, as no path that was followed explains the pictures better
  };
  Origin origin = Origin::kNotFollowed;
  std::map<int, SE3>
      camera_to_world;         ///< by the frame's index; empty: the camera is still, or the frames say where it is
  std::map<int, double> times; ///< seconds, of the same frames
  double depth_lag = 0;        ///< seconds by which depth comes later than colour, as far as its motion tells
  // Where it was followed:
  std::optional<std::size_t> moving_from; ///< frame of the timeline that showed motion, if it moves
  std::size_t tracked = 0;                ///< frames that show where the camera is
  std::size_t held = 0;                   ///< frames that follow the motion so far
  std::size_t lost = 0;                   ///< frames that do not show where the camera is
  std::size_t key_frames = 0;
  std::size_t loops = 0; ///< pairs of key frames that were found to see the same surface

  bool moves() const { return !camera_to_world.empty(); }
};

/// Follows the camera through the frames of a capture without poses (tracking::CameraTracker), which is read to its
/// end; its depth is already earlier by `depth_lag`, to which is added what is found. The same bits for any number of
/// threads. Throws what the capture throws.
CameraPath follow_camera(ingest::Capture& capture, const tracking::CameraTrackerConfig& config, double depth_lag,
                         StageTimes& times, Progress& progress);

/// The capture with depth as the colour camera had it before it at the moment of colour (tracking::depth_to_color):
/// carried by the path's lag, and by the time since it first came where a frame repeats the depth of the one before,
/// but not its colour, as those do whose sensor measures it less often. Frames of the path and others between them. The
/// capture itself if the path does not move.
std::unique_ptr<ingest::Capture> depth_in_time(std::unique_ptr<ingest::Capture> capture,
                                               std::shared_ptr<const CameraPath> path);

/// The capture with the path's poses in its frames, and depth_in_time(): it has poses then. The capture itself if the
/// path does not move. A frame that the path does not know is Error(kCorruptInput): the capture changed between two
/// readings.
std::unique_ptr<ingest::Capture> posed_capture(std::unique_ptr<ingest::Capture> capture,
                                               std::shared_ptr<const CameraPath> path);

} // namespace kinora::encode
