// Follows a person's skeleton through a capture, by depth and mask.
// Sources: Tagliasacchi et al., "Robust Articulated-ICP for Real-Time Hand Tracking", SGP 2015; Yu et al.,
// "BodyFusion", ICCV 2017, and "DoubleFusion", CVPR 2018 (what a skeleton is good for beside a deformation graph).
#pragma once

#include <span>
#include <vector>

#include "motion/motion.h"
#include "tracking/body/body_energy.h"
#include "tracking/body/body_pose_database.h"
#include "tracking/body/limb_search.h"
#include "tracking/rigid/contact.h"

namespace kinora::tracking {

/// Standard deviations of a frame's motion from what is expected, at 30 frames per second: metres and radians.
struct BodyMotionConfig {
  double root_translation = 0.02;
  double root_rotation = 0.06;
  double trunk_rotation = 0.04; ///< of each joint, as those below
  double arm_rotation = 0.15;
  double leg_rotation = 0.08;
  double velocity_weight = 0.8; ///< of a frame's velocity that is expected in the next
};

/// When a limb is looked for elsewhere, and what it must be worth.
struct LimbSearchConfig {
  double jump = 0.05;                   ///< metres of the body beyond what is expected: from less, alignment finds back
  double unexplained = 3;               ///< patches of measured surface about a limb: above, it is looked for
  double unexplained_beside_unseen = 1; ///< likewise, where nothing has shown it
  double max_free_space_share = 0.25;   ///< of the rest of its surface: above, likewise
  double margin = 3;                    ///< energy that another pose of it must save
  double jump_cost = 20;                ///< and per metre that it is away
  double unseen_jump_cost = 5;          ///< from where nothing has shown it
  int pause = 3;                        ///< frames after a search in vain
};

struct BodyTrackerConfig {
  BodyEnergyConfig energy;
  std::size_t max_points = 1200;
  int iterations = 8;             ///< of each frame
  std::size_t first_pixels = 400; ///< with clean depth that the first frame must have
  std::size_t min_pixels = 60;    ///< fewer: the pose is held
  bool use_searches = true;       ///< after the first fit; false: as predicted and aligned, no jumps are looked for
  int shape_frames = 20;          ///< that the measures are learned from
  double min_explained = 0.5;     ///< share of the measured surface that the body lies on; below, it is lost
  int lost_frames = 3;            ///< or held, in a row, after which size and pose are fitted anew
  /// Of the heels of both hands. Fingers are long, and of most objects only the front is known.
  ContactConfig contact{.reach = 0.2, .assumes_contact = true};
  BodyMotionConfig motion;
  LimbSearchConfig search;
  BodyPrior known; ///< of the measures, before anything is seen; its pose is not used
};

/// One frame's answer.
struct BodyTrackingResult {
  motion::Health health = motion::Health::kLost;
  std::array<LimbHealth, kLimbs> limbs{}; ///< of forearm and hand, or shank and foot
  double explained = 0;                   ///< share of the measured surface that the body lies on
  double free_space_share = 0; ///< share of the body's surface, of what nothing hides, that the camera sees past
  std::size_t detected = 0;    ///< joints that a detector has found
  bool refitted = false;       ///< size and pose were fitted anew: what was known of the bones does not go on
};

/// Not thread-safe. Same views, same bits, for any number of threads.
class BodyTracker {
public:
  explicit BodyTracker(const BodyTrackerConfig& config = {})
      : config_(config), contacts_(config.contact), known_(config.known) {}

  /// Views of the person's layer in order of time (seconds). `objects`: those that the hands may hold, as they are in
  /// this frame.
  BodyTrackingResult track(const LayerView& view, const SE3& camera_to_world, double time,
                           std::span<const NearbyObject> objects = {});

  bool started() const { return started_; }
  /// The body in the last frame; the pose's root is in the world.
  const BodyState& state() const { return state_; }

private:
  void begin(const LayerView& view, const SE3& camera_to_world);
  BodyState predicted(double seconds) const;
  PoseStep pose_precision(double seconds) const;
  void follow(BodyEvidence evidence, const SE3& camera_to_world, double seconds, std::span<const NearbyObject> objects,
              BodyTrackingResult& result);
  void move_to(const BodyState& state, double seconds);
  void learn_shape(const BodyEvidence& evidence, const BodyState& in_camera);
  void update_contacts(std::span<const NearbyObject> objects, const BodyTrackingResult& result);
  void search_limbs(const BodyEvidence& evidence, const BodyPrior& prior, BodyState& state, BodyTrackingResult& result);
  double explained_share(const BodyEvidence& evidence, const BodyState& in_camera) const;
  double free_space_share(const BodyEvidence& evidence, const BodyState& in_camera) const;

  BodyTrackerConfig config_;
  bool started_ = false;
  double time_ = 0;
  BodyState state_;
  PoseStep velocity_ = PoseStep::Zero();             ///< per second
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero(); ///< of what was measured in the last frame, in the world
  std::vector<JointObservation> observed_;           ///< in the last frame
  ContactTracker contacts_;                          ///< of both hands
  bool fresh_ = true;                                ///< fitted anew in this frame
  int lost_frames_ = 0;                              ///< in a row
  BodyPoseDatabase pose_database_;                   ///< in which it was tracked
  BodyPrior known_;                                  ///< of the measures
  int shape_frames_ = 0;
  std::array<LimbHealth, kLimbs> limbs_{}; ///< in the last frame
  std::array<bool, kLimbs> jumped_{};      ///< found by a search in this frame
  std::array<int, kLimbs> search_pause_{}; ///< frames until it is worth another search
};

} // namespace kinora::tracking
