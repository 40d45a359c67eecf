#include "tracking/camera/camera_tracker.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/parallel.h"
#include "tracking/camera/camera_stationarity.h"
#include "tracking/scenes/room_scene.h"

namespace kinora::tracking {
namespace {

using testing::pose_at;
using testing::render_room;
using testing::RoomOptions;

constexpr double kDegrees = 180 / 3.14159265358979;

/// Worst errors of a path whose first pose is the identity.
struct Errors {
  double metres = 0;
  double degrees = 0;
};

Errors errors_of(const std::vector<SE3>& path, const std::vector<SE3>& truth) {
  Errors errors;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const SE3 difference = path[i].inverse() * truth.front().inverse() * truth[i];
    errors.metres = std::max(errors.metres, difference.translation().norm());
    errors.degrees = std::max(errors.degrees, kDegrees * rotation_angle(difference));
  }
  return errors;
}

// A hand that carries the camera along and looks about.
SE3 moving_pose(int i) {
  return pose_at({0.25 * std::sin(0.12 * i), 0.1 * std::sin(0.2 * i), 0.15 * (1 - std::cos(0.1 * i))},
                 4 * std::sin(0.15 * i), 15 * std::sin(0.1 * i), 3 * std::sin(0.2 * i));
}

std::vector<SE3> moving_poses(int count) {
  std::vector<SE3> poses(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) poses[static_cast<std::size_t>(i)] = moving_pose(i);
  return poses;
}

CameraTracker follow(const std::vector<SE3>& poses, const RoomOptions& options) {
  CameraTracker tracker;
  for (std::size_t i = 0; i < poses.size(); ++i) tracker.track(render_room(poses[i], static_cast<int>(i), options));
  return tracker;
}

TEST(CameraTracker, AStillCameraStaysWhereItIsToTheBit) {
  const CameraTracker tracker = follow(std::vector<SE3>(10, SE3::Identity()), {});
  EXPECT_FALSE(tracker.moves());
  EXPECT_EQ(tracker.keyframe_count(), 1U);
  for (const SE3& pose : tracker.path()) EXPECT_EQ(pose.matrix(), SE3::Identity().matrix());
  for (const auto& result : tracker.results()) {
    EXPECT_EQ(result.camera_to_world.matrix(), SE3::Identity().matrix());
    EXPECT_EQ(result.health, motion::Health::kTracked);
  }
}

TEST(CameraTracker, AStillCameraStaysStillWhateverMovesBeforeIt) {
  for (const bool labelled : {true, false}) {
    CameraTracker tracker;
    RoomOptions options;
    options.mover_has_label = labelled;
    for (int i = 0; i < 15; ++i) {
      options.mover = pose_at({-0.3 + 0.04 * i, 0.1, 1.1}, 0, 4 * i);
      tracker.track(render_room(SE3::Identity(), i, options));
    }
    EXPECT_FALSE(tracker.moves()) << labelled;
  }
}

TEST(CameraTracker, AStillCameraStaysStillWhenTheLightChanges) {
  CameraTracker tracker;
  RoomOptions options;
  for (int i = 0; i < 12; ++i) {
    options.light = i % 4 < 2 ? 1 : 0.6;
    tracker.track(render_room(SE3::Identity(), i, options));
  }
  EXPECT_FALSE(tracker.moves());
}

TEST(CameraTracker, FollowsAHandHeldCameraWithinFiveMillimetres) {
  const std::vector<SE3> truth = moving_poses(40);
  const CameraTracker tracker = follow(truth, {});
  ASSERT_TRUE(tracker.moves());
  const Errors errors = errors_of(tracker.path(), truth);
  EXPECT_LT(errors.metres, 0.005);
  EXPECT_LT(errors.degrees, 0.15);
  EXPECT_GT(tracker.keyframe_count(), 1U);
}

TEST(CameraTracker, AStripOfFloorShowsThatTheCameraMoves) {
  CameraTracker tracker;
  const std::vector<SE3> truth = moving_poses(30);
  for (int i = 0; i < 30; ++i) {
    ingest::Frame frame = render_room(truth[static_cast<std::size_t>(i)], i);
    constexpr int kRange = 104; // row above which everything is out of the sensor's range
    std::fill_n(frame.depth.data(), kRange * frame.depth.width(), 0.0F);
    frame.clean_depth = frame.depth;
    tracker.track(frame);
  }
  ASSERT_TRUE(tracker.moves());
  EXPECT_LT(errors_of(tracker.path(), truth).metres, 0.01);
}

TEST(CameraTracker, FollowsByGeometryWhereNothingHasTexture) {
  RoomOptions options;
  options.textured = false;
  const std::vector<SE3> truth = moving_poses(30);
  const Errors errors = errors_of(follow(truth, options).path(), truth);
  EXPECT_LT(errors.metres, 0.01);
  EXPECT_LT(errors.degrees, 0.3);
}

TEST(CameraTracker, FollowsTheRoomAndNotTheThingThatTheCameraMovesAlongWith) {
  CameraTracker tracker;
  RoomOptions options;
  options.mover_has_label = true;
  const std::vector<SE3> truth = moving_poses(30);
  for (int i = 0; i < 30; ++i) {
    const SE3& camera = truth[static_cast<std::size_t>(i)];
    options.mover = camera * pose_at({0.05, 0, 1.2}, 0, 30);
    tracker.track(render_room(camera, i, options));
  }
  const Errors errors = errors_of(tracker.path(), truth);
  EXPECT_LT(errors.metres, 0.006);
  EXPECT_LT(errors.degrees, 0.2);
}

TEST(CameraTracker, FollowsACameraThatRollsThreeDegreesAFrame) {
  std::vector<SE3> truth(30);
  for (int i = 0; i < 30; ++i) {
    truth[static_cast<std::size_t>(i)] = pose_at({0, 0, 0}, 0, 0, 1.5 * i * std::min(i, 20) / 10.0);
  }
  const Errors errors = errors_of(follow(truth, {}).path(), truth);
  EXPECT_LT(errors.metres, 0.006);
  EXPECT_LT(errors.degrees, 0.2);
}

TEST(CameraTracker, DarknessLowersTheHealthAndNotTheMap) {
  RoomOptions options;
  CameraTracker tracker;
  const std::vector<SE3> truth = moving_poses(36);
  std::size_t before = 0;
  for (int i = 0; i < 36; ++i) {
    const bool dark = i >= 12 && i < 24;
    options.light = dark ? 0.004 : 1;
    if (i == 12) before = tracker.keyframe_count();
    const auto result = tracker.track(render_room(truth[static_cast<std::size_t>(i)], i, options));
    if (dark) {
      EXPECT_EQ(result.health, motion::Health::kHeld) << i;
      EXPECT_EQ(tracker.keyframe_count(), before) << i;
    } else if (i > 26) {
      EXPECT_EQ(result.health, motion::Health::kTracked) << i;
    }
  }
  const Errors errors = errors_of(tracker.path(), truth);
  EXPECT_LT(errors.metres, 0.01);
  EXPECT_LT(errors.degrees, 0.3);
}

TEST(CameraTracker, ABareWallLowersTheHealthAndNotTheMap) {
  CameraTracker tracker;
  const std::vector<SE3> truth = moving_poses(30);
  std::size_t before = 0;
  for (int i = 0; i < 30; ++i) {
    RoomOptions options;
    options.only_wall = i >= 12 && i < 18;
    if (i == 12) before = tracker.keyframe_count();
    const auto result = tracker.track(render_room(truth[static_cast<std::size_t>(i)], i, options));
    if (options.only_wall) {
      EXPECT_NE(result.health, motion::Health::kTracked) << i;
      EXPECT_EQ(tracker.keyframe_count(), before) << i;
    } else if (i > 18) {
      EXPECT_EQ(result.health, motion::Health::kTracked) << i;
    }
  }
  const std::vector<SE3> path = tracker.path();
  for (std::size_t i = 19; i < 30; ++i) {
    EXPECT_LT((path[i].translation() - truth[i].translation()).norm(), 0.008) << i;
  }
}

TEST(CameraTracker, ClosesTheLoopOfATurnAllAroundWithoutAJump) {
  std::vector<SE3> truth;
  for (int i = 0; i <= 124; ++i) truth.push_back(pose_at({0, 0, 0}, 0, i < 8 ? 3.0 * i * i / 16 : 3.0 * (i - 4)));
  const CameraTracker tracker = follow(truth, {});
  ASSERT_TRUE(tracker.moves());
  EXPECT_GT(tracker.loop_count(), 0U);
  const std::vector<SE3> path = tracker.path();
  const Errors errors = errors_of(path, truth);
  EXPECT_LT(errors.metres, 0.01);
  EXPECT_LT(errors.degrees, 0.5);
  EXPECT_LT((path.back().translation() - truth.back().translation()).norm(), 0.005);
  const auto& live = tracker.results();
  for (std::size_t i = *tracker.moving_from() + 1; i < live.size(); ++i) {
    const SE3 step = live[i - 1].camera_to_world.inverse() * live[i].camera_to_world;
    EXPECT_LT(step.translation().norm(), 0.006) << i;
  }
}

TEST(CameraTracker, GivesTheSameBitsForAnyNumberOfThreads) {
  const std::vector<SE3> truth = moving_poses(12);
  set_thread_count(1);
  const std::vector<SE3> one = follow(truth, {}).path();
  set_thread_count(3);
  const std::vector<SE3> three = follow(truth, {}).path();
  set_thread_count(0);
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_EQ(one[i].matrix(), three[i].matrix()) << i;
}

TEST(CameraTracker, WaitsForAFrameThatShowsSomething) {
  CameraTracker tracker;
  ingest::Frame empty = render_room(SE3::Identity(), 0);
  empty.depth = empty.clean_depth = DepthImage(160, 120);
  EXPECT_EQ(tracker.track(empty).health, motion::Health::kLost);
  EXPECT_EQ(tracker.track(render_room(SE3::Identity(), 1)).health, motion::Health::kTracked);
  EXPECT_EQ(tracker.path().size(), 2U);
}

TEST(CameraTracker, RefusesAFrameWhoseImagesDiffer) {
  ingest::Frame frame = render_room(SE3::Identity(), 0);
  frame.color = ColorImage(80, 60, 3);
  EXPECT_THROW(CameraTracker().track(frame), Error);
}

TEST(StationarityVotes, OnlyManyCellsThatAgreeOnAVisibleShiftShowMotion) {
  EXPECT_TRUE((StationarityVotes{14, 0, 2.0}.show_motion()));
  EXPECT_FALSE((StationarityVotes{14, 0, 0.9}.show_motion())) << "less than a camera can tell";
  EXPECT_FALSE((StationarityVotes{13, 0, 2.0}.show_motion())) << "may be chance";
  EXPECT_TRUE((StationarityVotes{32, 8, 2.0}.show_motion()));
  EXPECT_FALSE((StationarityVotes{32, 9, 2.0}.show_motion())) << "a part of the scene moves";
  EXPECT_FALSE((StationarityVotes{0, 0, 2.0}.show_motion()));
}

} // namespace
} // namespace kinora::tracking
