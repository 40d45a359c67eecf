#include "tracking/rigid/rigid_tracker.h"

#include <limits>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/parallel.h"
#include "tracking/scenes/synthetic_scene.h"

namespace kinora::tracking {
namespace {

using testing::pose_at;
using testing::render_frame;
using testing::SceneOptions;
using testing::Shape;
using testing::ShapeKind;

constexpr double kDegrees = 180 / 3.14159265358979;

/// Worst errors of a run: at the object's centre, and of the rotation.
struct Errors {
  double metres = 0;
  double degrees = 0;
};

// The error of the motion since the first pose, carried to the object's centre.
void add_error(const SE3& estimated, const SE3& first, const SE3& now, Errors& errors) {
  const SE3 truth = now * first.inverse();
  errors.metres = std::max(errors.metres, (estimated * first.translation() - now.translation()).norm());
  errors.degrees = std::max(errors.degrees, kDegrees * rotation_angle(estimated.inverse() * truth));
}

// A box that is turned and carried about, one metre away.
SE3 moving_pose(int i) {
  return pose_at({0.1 * std::sin(0.15 * i), 0.05 * std::cos(0.1 * i), 1 + 0.05 * std::sin(0.1 * i)}, 20 + 1.5 * i,
                 30 + 20 * std::sin(0.1 * i), 0.5 * i);
}

Errors follow(const Shape& shape, const std::vector<SE3>& poses, const SceneOptions& options,
              const SE3& camera_to_world = SE3::Identity()) {
  RigidTracker tracker(2);
  Errors errors;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto result = tracker.track(render_frame(shape, poses[i], camera_to_world, static_cast<int>(i), options));
    EXPECT_EQ(result.pose.health, motion::Health::kTracked) << "frame " << i;
    add_error(result.pose.canonical_to_world, poses[0], poses[i], errors);
  }
  return errors;
}

std::vector<SE3> moving_poses(int count) {
  std::vector<SE3> poses(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) poses[static_cast<std::size_t>(i)] = moving_pose(i);
  return poses;
}

TEST(RigidTracker, FollowsANoisyBoxWithinTwoMillimetresAndOneDegree) {
  SceneOptions options;
  options.noise = 1;
  const Errors errors = follow({}, moving_poses(16), options);
  EXPECT_LT(errors.metres, 0.002);
  EXPECT_LT(errors.degrees, 1.0);
}

TEST(RigidTracker, FollowsABoxWithoutTexture) {
  SceneOptions options;
  options.noise = 1;
  const Errors errors = follow({ShapeKind::kBox, {0.12, 0.09, 0.07}, false}, moving_poses(10), options);
  EXPECT_LT(errors.metres, 0.004);
  EXPECT_LT(errors.degrees, 1.5);
}

TEST(RigidTracker, FollowsANoisyBoxThreeMetresAway) {
  SceneOptions options;
  options.noise = 1;
  options.focal = 525;
  std::vector<SE3> poses = moving_poses(8);
  for (SE3& pose : poses) pose.translation().z() += 2;
  const Errors errors = follow({ShapeKind::kBox, {0.2, 0.15, 0.12}, true}, poses, options);
  EXPECT_LT(errors.metres, 0.008);
  EXPECT_LT(errors.degrees, 2.5);
}

TEST(RigidTracker, FollowsStepsOfFiveCentimetresAndFifteenDegrees) {
  std::vector<SE3> poses(6);
  for (int i = 0; i < 6; ++i) {
    poses[static_cast<std::size_t>(i)] = pose_at({-0.12 + 0.04 * i, 0.03 * (i % 2), 1}, 25, 30 - 15 * i);
  }
  SceneOptions options;
  options.noise = 1;
  const Errors errors = follow({}, poses, options);
  EXPECT_LT(errors.metres, 0.006);
  EXPECT_LT(errors.degrees, 1.5);
}

TEST(RigidTracker, IsAsExactAKilometreAwayFromTheWorldsOrigin) {
  const std::vector<SE3> poses = moving_poses(8);
  SceneOptions options;
  options.noise = 1;
  const SE3 far_away(Eigen::Translation3d(1000, -300, 700));
  RigidTracker here(2);
  RigidTracker there(2);
  for (int i = 0; i < 8; ++i) {
    const SE3& pose = poses[static_cast<std::size_t>(i)];
    const auto a = here.track(render_frame({}, pose, SE3::Identity(), i, options));
    const auto b = there.track(render_frame({}, far_away * pose, far_away, i, options));
    const Eigen::Vector3d moved_here = a.pose.canonical_to_world * poses[0].translation();
    const Eigen::Vector3d moved_there = b.pose.canonical_to_world * (far_away * poses[0].translation());
    EXPECT_LT((moved_there - far_away * moved_here).norm(), 1e-4) << "frame " << i;
  }
}

TEST(RigidTracker, SeesAStillObjectStandStillWhileTheCameraMoves) {
  const SE3 object = pose_at({0, 0, 1}, 20, 30);
  SceneOptions options;
  options.noise = 1;
  RigidTracker tracker(2);
  for (int i = 0; i < 12; ++i) {
    const SE3 camera = pose_at({0.02 * i, 0.01 * i, 0}, 0.5 * i, -i);
    const auto result = tracker.track(render_frame({}, object, camera, i, options));
    ASSERT_EQ(result.pose.health, motion::Health::kTracked);
    Errors errors;
    add_error(result.pose.canonical_to_world, object, object, errors);
    EXPECT_LT(errors.metres, 0.002);
    EXPECT_LT(errors.degrees, 0.7);
  }
}

TEST(RigidTracker, FollowsABoxOfWhichHalfIsHidden) {
  SceneOptions options;
  options.noise = 1;
  RigidTracker tracker(2);
  Errors errors;
  for (int i = 0; i < 12; ++i) {
    options.occluded_columns = i < 5 ? 0 : 115 + static_cast<int>(20 * std::sin(0.15 * i));
    const auto result = tracker.track(render_frame({}, moving_pose(i), SE3::Identity(), i, options));
    EXPECT_EQ(result.pose.health, motion::Health::kTracked) << "frame " << i;
    add_error(result.pose.canonical_to_world, moving_pose(0), moving_pose(i), errors);
  }
  EXPECT_LT(errors.metres, 0.003);
  EXPECT_LT(errors.degrees, 1.2);
}

TEST(RigidTracker, DoesNotFuseAnOccluderThatCarriesTheObjectsLabel) {
  SceneOptions options;
  const SE3 pose = pose_at({0, 0, 1}, 20, 30);
  RigidTracker tracker(2);
  for (int i = 0; i < 8; ++i) {
    options.occluded_columns = i < 3 ? 0 : 115;
    options.occluder_has_label = false;
    tracker.track(render_frame({}, pose, SE3::Identity(), i, options));
  }
  for (const SurfacePoint& point : tracker.model()->surface_points()) {
    EXPECT_GT(point.position.z() + tracker.model()->origin().z(), 0.8);
  }
}

TEST(RigidTracker, IsLostBeforeTheObjectAppearsAndStartsThere) {
  RigidTracker tracker(2);
  for (int i = 0; i < 3; ++i) {
    const auto result = tracker.track(render_frame({}, pose_at({9, 0, 1}, 0, 0), SE3::Identity(), i));
    EXPECT_EQ(result.pose.health, motion::Health::kLost);
    EXPECT_FALSE(result.visible);
    EXPECT_EQ(tracker.model(), nullptr);
  }
  const auto first = tracker.track(render_frame({}, moving_pose(0), SE3::Identity(), 3));
  EXPECT_EQ(first.pose.health, motion::Health::kTracked);
  EXPECT_TRUE(first.pose.canonical_to_world.isApprox(SE3::Identity(), 1e-12));
  for (const motion::Motion::Pose& pose : tracker.poses()) {
    EXPECT_TRUE(pose.canonical_to_world.isApprox(SE3::Identity(), 1e-12));
  }
}

TEST(RigidTracker, HoldsAVanishedObjectThenCallsItLostAndFindsItAgain) {
  RigidTrackerConfig config;
  config.held_frames = 4;
  RigidTracker tracker(2, config);
  for (int i = 0; i < 10; ++i) tracker.track(render_frame({}, moving_pose(i), SE3::Identity(), i));
  const SE3 last = tracker.poses().back().canonical_to_world;
  for (int i = 10; i < 16; ++i) {
    const auto result = tracker.track(render_frame({}, pose_at({9, 0, 1}, 0, 0), SE3::Identity(), i));
    EXPECT_EQ(result.pose.health, i < 14 ? motion::Health::kHeld : motion::Health::kLost);
    EXPECT_TRUE(result.pose.canonical_to_world.isApprox(last, 1e-12));
  }
  const SE3 back = Eigen::Translation3d(0.15, 0.05, 0.1) * moving_pose(2);
  const auto found = tracker.track(render_frame({}, back, SE3::Identity(), 16));
  ASSERT_EQ(found.pose.health, motion::Health::kTracked);
  EXPECT_TRUE(found.relocalised);
  Errors errors;
  add_error(found.pose.canonical_to_world, moving_pose(0), back, errors);
  EXPECT_LT(errors.metres, 0.002);
  EXPECT_LT(errors.degrees, 1.0);
}

TEST(RigidTracker, FindsALostObjectTurnedAsItWasSeenLongAgo) {
  RigidTracker tracker(2);
  const auto turned = [](double degrees) { return pose_at({0, 0, 1}, 20, degrees); };
  int i = 0;
  for (; i <= 30; ++i) {
    const auto result = tracker.track(render_frame({}, turned(5.0 * i), SE3::Identity(), i));
    ASSERT_EQ(result.pose.health, motion::Health::kTracked) << i;
  }
  for (const int end = i + 20; i < end; ++i)
    tracker.track(render_frame({}, pose_at({9, 0, 1}, 0, 0), SE3::Identity(), i));
  const SE3 back = Eigen::Translation3d(0.15, 0.05, 0.1) * turned(10); // 140 degrees from where it was lost
  const auto found = tracker.track(render_frame({}, back, SE3::Identity(), i));
  ASSERT_EQ(found.pose.health, motion::Health::kTracked);
  Errors errors;
  add_error(found.pose.canonical_to_world, turned(0), back, errors);
  EXPECT_LT(errors.metres, 0.005);
  EXPECT_LT(errors.degrees, 2.0);
}

// A box that is hidden wholly from the third frame on.
ingest::Frame behind_a_screen(int i) {
  SceneOptions options;
  options.occluded_columns = i < 3 ? 0 : 240;
  return render_frame({}, pose_at({0.01 * i, 0, 1}, 20, 30), SE3::Identity(), i, options);
}

TEST(RigidTracker, ObjectThatIsNotSeenGoesWithWhatHoldsIt) {
  RigidTrackerConfig config;
  config.held_frames = 4;
  RigidTracker tracker(2, config);
  for (int i = 0; i < 12; ++i) {
    const ingest::Frame frame = behind_a_screen(i);
    auto missed = tracker.track(frame).missed;
    EXPECT_EQ(missed.has_value(), i >= 3) << i;
    if (missed) tracker.move_with_contact(frame, std::move(*missed), SE3(Eigen::Translation3d(0.01 * (i - 2), 0, 0)));
    EXPECT_EQ(tracker.poses().back().health, i < 3 ? motion::Health::kTracked : motion::Health::kHeld) << i;
    Errors errors;
    add_error(tracker.poses().back().canonical_to_world, pose_at({0, 0, 1}, 20, 30), pose_at({0.01 * i, 0, 1}, 20, 30),
              errors);
    EXPECT_LT(errors.metres, 0.003) << i;
  }
}

TEST(RigidTracker, ObjectThatWouldBeSeenIsNotInTheHand) {
  RigidTracker tracker(2);
  for (int i = 0; i < 3; ++i) tracker.track(render_frame({}, moving_pose(i), SE3::Identity(), i));
  const SE3 last = tracker.poses().back().canonical_to_world;
  for (int i = 3; i < 6; ++i) {
    // In the last of these the hand is hidden again, which does not mean that the box is in it.
    const ingest::Frame frame =
        i < 5 ? render_frame({}, pose_at({9, 0, 1}, 0, 0), SE3::Identity(), i) : behind_a_screen(i);
    auto missed = tracker.track(frame).missed;
    ASSERT_TRUE(missed) << i;
    tracker.move_with_contact(frame, std::move(*missed), SE3(Eigen::Translation3d(0.1, 0, 0)));
    EXPECT_EQ(tracker.poses().back().canonical_to_world.matrix(), last.matrix()) << i;
  }
}

TEST(RigidTracker, SaysLostWhenWhatItSeesIsAnotherObject) {
  RigidTracker tracker(2);
  for (int i = 0; i < 5; ++i) tracker.track(render_frame({}, moving_pose(i), SE3::Identity(), i));
  const SE3 last = tracker.poses().back().canonical_to_world;
  const Shape ball{ShapeKind::kSphere, {0.25, 0, 0}, true};
  const auto result = tracker.track(render_frame(ball, pose_at({0.1, 0, 1.4}, 0, 0), SE3::Identity(), 5));
  EXPECT_EQ(result.pose.health, motion::Health::kLost);
  EXPECT_TRUE(result.pose.canonical_to_world.isApprox(last, 1e-12));
}

TEST(RigidTracker, SurvivesTinyMasksAndDepthThatIsNotThere) {
  RigidTracker tracker(2);
  for (int i = 0; i < 3; ++i) tracker.track(render_frame({}, moving_pose(i), SE3::Identity(), i));
  ingest::Frame tiny = render_frame({}, moving_pose(3), SE3::Identity(), 3);
  std::fill(tiny.labels.values().begin(), tiny.labels.values().end(), std::uint8_t{0});
  tiny.labels.at(160, 120) = 2;
  tiny.labels.at(161, 120) = 2;
  EXPECT_EQ(tracker.track(tiny).pose.health, motion::Health::kHeld);
  for (const float value : {0.0F, std::numeric_limits<float>::quiet_NaN(), -1.0F}) {
    ingest::Frame frame = render_frame({}, moving_pose(4), SE3::Identity(), 4);
    std::fill(frame.depth.values().begin(), frame.depth.values().end(), value);
    frame.clean_depth = frame.depth;
    const auto result = tracker.track(frame);
    EXPECT_EQ(result.pose.health, motion::Health::kHeld);
    EXPECT_FALSE(result.visible);
  }
  ingest::Frame unlabelled = render_frame({}, moving_pose(5), SE3::Identity(), 5);
  unlabelled.labels = LabelImage();
  EXPECT_EQ(tracker.track(unlabelled).pose.health, motion::Health::kHeld);
  EXPECT_EQ(tracker.track(render_frame({}, moving_pose(6), SE3::Identity(), 6)).pose.health, motion::Health::kTracked);
}

TEST(RigidTracker, RejectsAFrameWhoseImagesDiffer) {
  RigidTracker tracker(2);
  ingest::Frame frame = render_frame({}, moving_pose(0), SE3::Identity(), 0);
  frame.clean_depth = DepthImage(3, 3);
  EXPECT_THROW(tracker.track(frame), Error);
}

TEST(RigidTracker, DoesNotMoveWhenAFrameIsRepeated) {
  SceneOptions options;
  options.noise = 1;
  RigidTracker tracker(2);
  const ingest::Frame frame = render_frame({}, moving_pose(0), SE3::Identity(), 0, options);
  Errors errors;
  for (int i = 0; i < 10; ++i) {
    add_error(tracker.track(frame).pose.canonical_to_world, moving_pose(0), moving_pose(0), errors);
  }
  EXPECT_LT(errors.metres, 0.0005);
  EXPECT_LT(errors.degrees, 0.1);
}

TEST(RigidTracker, NamesTheWeakDirectionsOfABallAndDoesNotDriftInTheStrongOnes) {
  const Shape ball{ShapeKind::kSphere, {0.12, 0, 0}, false};
  SceneOptions options;
  options.noise = 1;
  RigidTracker tracker(2);
  for (int i = 0; i < 12; ++i) {
    const SE3 pose = pose_at({0.004 * i, -0.002 * i, 1 + 0.003 * i}, 0, 0);
    const auto result = tracker.track(render_frame(ball, pose, SE3::Identity(), i, options));
    ASSERT_EQ(result.pose.health, motion::Health::kTracked) << "frame " << i;
    if (i > 0) {
      EXPECT_EQ(result.degenerate_directions, 3) << "frame " << i;
    }
    const Eigen::Vector3d centre = result.pose.canonical_to_world * Eigen::Vector3d(0, 0, 1);
    EXPECT_LT((centre - pose.translation()).norm(), 0.003) << "frame " << i;
  }
}

TEST(RigidTracker, HasTheSameBitsForAnyNumberOfThreads) {
  std::vector<std::vector<motion::Motion::Pose>> runs;
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    SceneOptions options;
    options.noise = 1;
    RigidTracker tracker(2);
    for (int i = 0; i < 8; ++i) tracker.track(render_frame({}, moving_pose(i), SE3::Identity(), i, options));
    runs.push_back(tracker.poses());
  }
  set_thread_count(0);
  for (std::size_t i = 0; i < runs[0].size(); ++i) {
    EXPECT_EQ(runs[0][i].canonical_to_world.matrix(), runs[1][i].canonical_to_world.matrix());
  }
}

} // namespace
} // namespace kinora::tracking
