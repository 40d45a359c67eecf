// Finds where the camera is, frame by frame, from what it sees of the background: geometry and texture against key
// frames, whose poses a graph keeps in agreement.
// Source: Kerl, Sturm, Cremers, "Dense Visual SLAM for RGB-D Cameras", IROS 2013 (key frames and their graph).
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "motion/motion.h"
#include "tracking/camera/camera_keyframe.h"
#include "tracking/camera/depth_lag.h"
#include "tracking/camera/loop_closure.h"
#include "tracking/camera/pose_graph.h"
#include "tracking/lost/held_or_lost.h"

namespace kinora::tracking {

/// What is expected of a camera that is held in hand.
struct CameraMotionConfig {
  double max_extrapolation = 0.2;  ///< seconds that the last velocity is believed to last
  double velocity_weight = 0.95;   ///< of it that is expected, and
  double velocity_decay = 0.8;     ///< of that after each frame that shows no motion, or not in all directions
  double max_angular_velocity = 4; ///< radians per second
  double max_velocity = 2;         ///< metres per second
};

/// How a camera that was lost is found again.
struct CameraRelocalisationConfig {
  std::size_t keyframes = 4;  ///< that it is looked for at
  double feature_size = 0.15; ///< over the distance of what the first key frame shows
  double same_pose = 0.1;     ///< change of view that places which are one may differ by
};

struct CameraTrackerConfig {
  std::size_t min_pixels = 2000;   ///< of the reduced background with clean depth that the first key frame must have
  double keyframe_change = 0.15;   ///< of the view (view_change) from which on a key frame is made
  double loop_change = 0.5;        ///< up to which older key frames are compared with a new one
  std::size_t max_loops = 4;       ///< key frames that a new one is compared with
  std::size_t references = 3;      ///< key frames that a frame is aligned to at once
  std::size_t max_keyframes = 400; ///< 0.6 MB each
  int frames_to_move = 3;          ///< in a row that must show motion before the camera counts as moving; 0: it does
  int held_frames = 30;            ///< without support for longer: lost
  std::size_t max_points = 1200;   ///< that a frame is aligned to
  double uncertain_edge_weight = 0.01; ///< of an edge over frames that did not show where the camera was
  CameraMotionConfig motion;
  CameraRelocalisationConfig relocalisation;
  LoopClosureConfig loops;
};

/// One frame's answer.
struct CameraTrackingResult {
  SE3 camera_to_world = SE3::Identity(); ///< world = camera of the first key frame, normally of frame 0
  motion::Health health = motion::Health::kTracked;
  PoseQuality quality;
  int degenerate_directions = 0; ///< left to the motion prior, of six
};

/// The camera is still, and its pose exactly the identity, until several frames in a row are explained significantly
/// better by another pose (StationarityVotes), unless the configuration says that it moves. Health: kTracked: geometry
/// and texture support the pose in all directions; kHeld: some directions, or all, follow the motion so far; kLost:
/// without support for long. Only tracked frames become key frames. Loops are closed among the key frames as they are
/// made; the live poses stay continuous, `path` has the corrected ones. Not thread-safe. Same frames, same bits, for
/// any number of threads.
class CameraTracker {
public:
  explicit CameraTracker(const CameraTrackerConfig& config = {})
      : config_(config), far_loops_(config.loops), gap_(config.held_frames) {}

  /// Frames in order of time; their own poses are not looked at. A frame without labels is all background.
  /// Throws Error(kFailure) if the frame's images differ in size.
  CameraTrackingResult track(const ingest::Frame& frame);

  bool moves() const { return moving_from_.has_value(); }
  /// Index of the frame that showed motion.
  std::optional<std::size_t> moving_from() const { return moving_from_; }
  /// The live answers, one per frame.
  const std::vector<CameraTrackingResult>& results() const { return results_; }
  /// Camera to world of every frame, as all that was seen has it: loops are closed, and stretches without support lead
  /// from where the camera was lost to where it was found. All identity if the camera never moved.
  std::vector<SE3> path() const;
  /// Seconds by which depth comes later than colour, of all frames so far (estimate_depth_lag).
  std::optional<double> depth_lag() const { return estimate_depth_lag(lag_evidence_, path(), times_); }
  std::size_t keyframe_count() const { return keyframes_.size(); }
  /// Pairs of key frames, not made one after the other, that were found to see the same surface.
  std::size_t loop_count() const { return loops_; }

private:
  struct RelativePose {
    std::size_t keyframe;
    SE3 camera_to_keyframe;
  };
  /// Frames that did not show where the camera was in all directions, up to one that did.
  struct Gap {
    std::size_t first;
    std::size_t count;
    RelativePose expected; ///< where the motion before would have led by then
  };

  void follow(const BackgroundFrame& reduced, const LayerView& view, CameraTrackingResult& result);
  SE3 extrapolated(double time, double share) const;
  std::vector<std::size_t> nearest_keyframes(const SE3& camera_to_map, std::size_t count) const;
  std::vector<std::size_t> references_for(const SE3& camera_to_map, std::size_t reference) const;
  CameraFit fit_near(const LayerView& view, const SE3& camera_to_map, std::size_t reference, int coarsest_level,
                     RelativePose& found) const;
  CameraFit find_pose(const LayerView& view, double time, const SE3& expected, RelativePose& found);
  bool is_reachable(const SE3& camera_to_map, double time) const;
  bool relocalise_by_features(const LayerView& view, double time, const SE3& expected, CameraFit& fit,
                              RelativePose& found) const;
  SurfaceFeatures features_of(const LayerView& view, const SE3& camera_to_map) const;
  void test_stationarity(const LayerView& view, const SE3& camera_to_map);
  void grow_map(const BackgroundFrame& reduced, const LayerView& view, const SE3& camera_to_map);
  void add_keyframe(const BackgroundFrame& reduced, const LayerView& view, const SE3& camera_to_map);
  void add_lag_evidence(const LayerView& view);
  void add_edge(const PoseEdge& edge);
  bool close_near_loops(std::size_t previous, const LayerView& view);
  bool close_far_loops(const LayerView& view);
  void optimise_graph();
  SE3 map_pose(const RelativePose& relative) const { return map_[relative.keyframe] * relative.camera_to_keyframe; }

  CameraTrackerConfig config_;
  std::vector<CameraKeyframe> keyframes_;
  std::vector<std::size_t> keyframe_frames_; ///< of which frame each is
  std::vector<SE3> map_;                     ///< camera to map of each key frame
  std::vector<PoseEdge> edges_;
  std::vector<std::vector<std::size_t>> neighbours_; ///< of each key frame, by edges
  std::size_t loops_ = 0;
  LoopClosure far_loops_;
  std::size_t reference_ = 0; ///< key frame that the last frame was measured against
  SE3 map_to_live_ = SE3::Identity();
  std::vector<RelativePose> relative_poses_; ///< of all frames
  std::vector<Gap> gaps_;
  std::vector<CameraTrackingResult> results_;
  std::vector<double> times_; ///< of all frames
  std::vector<LagEvidence> lag_evidence_;
  Twist velocity_ = Twist::Zero(); ///< of the camera in its own space, per second
  double last_time_ = 0;
  HeldOrLost gap_;         ///< of frames that do not show where the camera is in all directions
  bool uncertain_ = false; ///< since the last key frame the camera was lost, and has not been found by features
  RelativePose anchor_{};  ///< the last that a frame showed in all directions
  double anchor_time_ = 0;
  int frames_with_motion_ = 0;
  std::optional<std::size_t> moving_from_;
};

} // namespace kinora::tracking
