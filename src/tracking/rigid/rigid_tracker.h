// Follows one rigid object through a capture and fuses what it sees of it into a model.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "ingest/frame/frame.h"
#include "motion/motion.h"
#include "tracking/lost/held_or_lost.h"
#include "tracking/rigid/non_rigidity.h"
#include "tracking/rigid/pose_quality.h"
#include "tracking/rigid/rigid_icp.h"
#include "tracking/tsdf/tsdf.h"
#include "tracking/view/frame_history.h"

namespace kinora::tracking {

/// Which tracked frames become part of the model.
struct RigidFusionConfig {
  int first_frames = 8;       ///< of the object: all of them are fused, and later
  int interval = 3;           ///< each so many, and all in which
  double min_coverage = 0.97; ///< the model explains less than this: new surface came into view
};

/// Where an object is looked for that is not, or may not be, where it is expected.
struct RigidSearchConfig {
  double doubtful_correlation = 0.6; ///< of the texture: below, other places are tried as well
  double certain_correlation = 0.85; ///< they are not, however little of the label is covered
  double silhouette_change = 0.05;   ///< of shares from frame to frame: they are
  double min_share_gain = 0.02;      ///< of the score, which is at most 3
  double rotation = 0.8;             ///< radians, of starts beyond what frames are expected to turn by
  double contact_rotation = 0.35;    ///< likewise: of starts beside where what holds it has it
  double explained_share = 0.9;      ///< of the label, if what goes with a hand is to have turned otherwise
  std::size_t max_keyframes = 16;    ///< directions of view that are stored, and started from
  double keyframe_angle = 0.4;       ///< radians between them
};

/// The earlier occluding contour that views are compared with.
struct ContourConfig {
  int max_age = 10;          ///< frames
  double max_rotation = 0.2; ///< radians from which on another is taken
  double max_change = 0.1;   ///< and the change of the label's pixels
};

struct RigidTrackerConfig {
  double voxel_size = 0;             ///< metres; 0: from the sensor's noise and the footprint of a pixel at the object
  std::size_t first_pixels = 100;    ///< pixels with clean depth that the first frame of the object must have
  std::size_t min_pixels = 60;       ///< fewer: the pose is held
  std::size_t max_points = 2500;     ///< model points used for alignment, spread over directions of the normal
  double min_inlier_share = 0.6;     ///< of the points that fall on the object; below, the pose is not believed
  double min_correlation = 0.3;      ///< of the texture, where there is any
  int held_frames = 30;              ///< unseen for longer: lost
  bool keeps_history = false;        ///< frames, so that they can be looked at again (memory)
  double max_free_space_share = 0.3; ///< of the points: above, they belong to something that is elsewhere
  double let_go_share = 0.5;         ///< of the surface that faces the camera, in free space: above, it was let go
  double min_detail_share = 0.25;    ///< of the pixels with detail: what never had as much is plain
  double velocity_weight = 0.95;     ///< of the last motion that the next one is expected to repeat
  int max_predicted_steps = 3;       ///< frames without it: after them, nothing is expected of that motion
  AlignmentConfig alignment;
  RigidFusionConfig fusion;
  RigidSearchConfig search;
  ContourConfig contour;
};

/// What a frame shows of an object that has been seen before but is not found in it: what RigidTracker::carry needs.
struct MissedObject {
  LayerView view;
};

/// One frame's answer.
struct RigidTrackingResult {
  motion::Motion::Pose pose;     ///< canonical = world at the object's first frame; identity before it
  bool visible = false;          ///< enough of its pixels were measured
  std::size_t pixels = 0;        ///< of the label, with clean depth
  PoseQuality quality;           ///< of the accepted, or the best refused pose
  int degenerate_directions = 0; ///< left to the motion prior, of six
  /// The weak directions in the world, as twists about the object's centre: metres, and radians × radius.
  std::vector<Twist> degenerate;
  bool relocalised = false;           ///< found again after having been held or lost
  std::optional<MissedObject> missed; ///< unless it was found, or has not been seen yet
};

/// Health: kTracked: the view supports the pose; kHeld: too little of the object is seen, the last pose stays;
/// kLost: it is seen but found nowhere, or unseen for long, or not yet seen at all. Only tracked frames are fused: all
/// while the object is new or shows new surface, else every third. Not thread-safe. Same frames, same bits, for any
/// number of threads.
class RigidTracker {
public:
  explicit RigidTracker(int label, const RigidTrackerConfig& config = {});
  ~RigidTracker();
  RigidTracker(RigidTracker&&) noexcept;
  RigidTracker& operator=(RigidTracker&&) noexcept;

  /// Frames in order of time. Throws Error(kFailure) if the frame's images differ in size.
  RigidTrackingResult track(const ingest::Frame& frame);

  /// What holds the object that the last frame has `missed` has moved like this in the world since the last one that
  /// has not. The object goes along, and is held, until the camera sees past most of where it would be: then it was let
  /// go, and stays. If the view shows it there, it is tracked again.
  void move_with_contact(const ingest::Frame& frame, MissedObject missed, const SE3& motion);

  int label() const { return label_; }
  /// Poses of all frames so far, for Motion::rigid.
  const std::vector<motion::Motion::Pose>& poses() const { return poses_; }
  /// The fused model in canonical space; nullptr before the object's first frame. Its intensity is the texture of
  /// LayerView.
  const TsdfVolume* model() const { return volume_.get(); }
  /// The model's surface, relative to the model's origin; valid until the next frame.
  std::span<const SurfacePoint> surface() const { return surface_; }
  /// That the object is none, for it bends; frames are counted as in poses().
  std::optional<NonRigidity> non_rigidity() const { return non_rigidity_test_.non_rigidity(); }
  /// Of all frames so far, if the tracker was told to remember.
  const FrameHistory& history() const { return history_; }

private:
  struct Candidate;
  struct PreviousFrame; ///< what is kept of the last tracked frame
  enum class StartSet { kNearPrevious, kKeyframes, kRotated, kRotatedDiagonally, kInContact };

  void mask_shading(LayerView& view);
  void begin(const ingest::Frame& frame, LayerView view, RigidTrackingResult& result);
  std::optional<Candidate> find(const ingest::Frame& frame, const LayerView& view, RigidTrackingResult& result);
  void accept(const ingest::Frame& frame, LayerView view, const Candidate& best, RigidTrackingResult& result);
  void fuse(const ingest::Frame& frame, const LayerView& view);
  bool is_visible(const LayerView& view) const { return view.depth_pixels >= config_.min_pixels; }
  bool is_in_free_space(const ingest::Frame& frame, const SE3& model_to_world) const;
  SE3 canonical_to_world() const;
  SE3 predicted(double time) const;
  Candidate align_from(const LayerView& view, const SE3& start, const SE3& prior, const ContourSource& contours) const;
  std::vector<SE3> start_poses(const LayerView& view, const SE3& camera_to_world, StartSet start_set) const;
  void update_contour();
  std::vector<ModelPoint> visible_points(const LayerView& view, const SE3& model_to_camera) const;
  bool is_healthy(const PoseQuality& quality) const;
  bool is_doubtful(const PoseQuality& quality) const;
  bool is_relocalised(const PoseQuality& quality) const;

  int label_;
  RigidTrackerConfig config_;
  std::unique_ptr<TsdfVolume> volume_;
  std::vector<SurfacePoint> surface_;
  SE3 model_to_world_ = SE3::Identity(); ///< model = canonical − the volume's origin
  std::unique_ptr<PreviousFrame> previous_;
  std::vector<Eigen::Matrix3d> keyframes_; ///< model-to-camera rotations from which the object was seen well
  HeldOrLost gap_;
  bool has_texture_detail_ = false;
  bool is_released_ = false;         ///< by what held it, since it was found last
  bool is_moved_by_contact_ = false; ///< in the last frame, by what holds it
  int fused_ = 0;                    ///< frames
  int unfused_ = 0;                  ///< tracked frames since the last that was fused
  std::vector<motion::Motion::Pose> poses_;
  NonRigidityTest non_rigidity_test_;
  FrameHistory history_;
};

} // namespace kinora::tracking
