#include "tracking/camera/loop_closure.h"

#include <gtest/gtest.h>

#include "tracking/camera/camera_tracker.h"
#include "tracking/scenes/loop_scenes.h"

namespace kinora::tracking {
namespace {

using testing::LoopScene;
using testing::pose_at;
using testing::render_room;
using testing::RoomOptions;

constexpr double kDegrees = 180 / 3.14159265358979;
constexpr double kFeatureSize = 0.3; // metres

CameraTracker follow(const LoopScene& scene) {
  CameraTracker tracker;
  for (std::size_t i = 0; i < scene.size(); ++i) tracker.track(scene.render(i));
  return tracker;
}

/// What the pose of a frame is wrong by, if the first one is right.
SE3 error_at(const LoopScene& scene, const std::vector<SE3>& path, std::size_t frame) {
  return (scene.truth.front().inverse() * scene.truth[frame]).inverse() * path[frame];
}

double worst_metres(const LoopScene& scene, const std::vector<SE3>& path) {
  double worst = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    worst = std::max(worst, error_at(scene, path, i).translation().norm());
  }
  return worst;
}

CameraKeyframe keyframe_of(const ingest::Frame& frame, const SE3& camera_to_map = SE3::Identity()) {
  const BackgroundFrame reduced = reduce_background(frame);
  const LayerView view = view_background(reduced);
  CameraKeyframe keyframe = make_keyframe(reduced, view);
  keyframe.features = find_features(view, camera_to_map.linear(), kFeatureSize);
  return keyframe;
}

class DriftingRotation : public ::testing::TestWithParam<std::uint64_t> {};

// 11 to 13° off at the end, if the loop is left open.
TEST_P(DriftingRotation, IsClosed) {
  const LoopScene scene = testing::rotate_around(GetParam());
  const std::vector<SE3> path = follow(scene).path();
  const SE3 last = error_at(scene, path, scene.size() - 1);
  EXPECT_LT(last.translation().norm(), 0.05);
  EXPECT_LT(kDegrees * rotation_angle(last), 1);
}

INSTANTIATE_TEST_SUITE_P(LoopClosure, DriftingRotation, ::testing::Values(1, 2, 5));

TEST(LoopClosure, ASlipInTheDarkIsUndoneWhenTheLoopCloses) {
  const LoopScene scene = testing::rotate_with_hard_stretches(3); // 0.8 m off at the end, if the loop is left open
  const CameraTracker tracker = follow(scene);
  const std::vector<SE3> path = tracker.path();
  const SE3 last = error_at(scene, path, scene.size() - 1);
  EXPECT_LT(last.translation().norm(), 0.05);
  EXPECT_LT(kDegrees * rotation_angle(last), 1.5);
  EXPECT_LT(worst_metres(scene, path), 0.25);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    if (scene.options[i].light == 1 && !scene.options[i].only_wall) continue;
    EXPECT_NE(tracker.results()[i].health, motion::Health::kTracked) << i;
  }
}

TEST(LoopClosure, ACameraThatWasCoveredIsFoundAgainElsewhereInTheRoom) {
  const LoopScene scene = testing::covered_on_the_way(1);
  const CameraTracker tracker = follow(scene);
  const std::vector<SE3> path = tracker.path();
  for (std::size_t i = 0; i < scene.size(); ++i) {
    if (scene.options[i].covered) {
      EXPECT_NE(tracker.results()[i].health, motion::Health::kTracked) << i;
    } else {
      EXPECT_EQ(tracker.results()[i].health, motion::Health::kTracked) << i;
      EXPECT_LT(error_at(scene, path, i).translation().norm(), 0.01) << i;
    }
  }
}

TEST(LoopClosure, DoesNotJoinPlacesThatLookAlike) {
  const LoopScene scene = testing::alike_place(2, 1);
  const std::size_t there = scene.size() - 12; // looks the way the camera looked first
  const CameraKeyframe first = keyframe_of(scene.render(0));
  const CameraKeyframe other = keyframe_of(scene.render(there));
  const auto start = register_by_features(first.features, other.features);
  ASSERT_TRUE(start);
  ASSERT_TRUE(relative_pose(first, other, view_background(other.frame), *start)) << "they look alike";
  ASSERT_GT((scene.truth[there].translation() - scene.truth[0].translation()).norm(), 0.7) << "and are not one";
  EXPECT_LT(worst_metres(scene, follow(scene).path()), 0.25);
}

TEST(CameraFeatures, TellWhereAViewStandsThoughItsMapHasTurnedByTenDegrees) {
  const SE3 b_to_a = pose_at({0.2, 0.05, 0.2}, 4, 12, 30);
  const SE3 drift = pose_at({0.4, 0, 0}, 4, 8, 4);
  const CameraKeyframe a = keyframe_of(render_room(SE3::Identity(), 0));
  const CameraKeyframe b = keyframe_of(render_room(b_to_a, 1), drift * b_to_a);
  const auto found = register_by_features(a.features, b.features);
  ASSERT_TRUE(found);
  const SE3 off = found->inverse() * b_to_a;
  EXPECT_LT(off.translation().norm(), 0.05);
  EXPECT_LT(kDegrees * rotation_angle(off), 2);
}

TEST(CameraFeatures, TellNothingOfAnotherPlaceNorOfBareWalls) {
  const CameraKeyframe a = keyframe_of(render_room(SE3::Identity(), 0));
  EXPECT_FALSE(register_by_features(a.features, keyframe_of(render_room(pose_at({0, 0, 0}, 0, 180), 1)).features));
  RoomOptions bare;
  bare.textured = false;
  const CameraKeyframe plain = keyframe_of(render_room(SE3::Identity(), 2, bare));
  EXPECT_EQ(count_matches(a.features, plain.features), 0U);
  EXPECT_FALSE(register_by_features(a.features, plain.features));
}

} // namespace
} // namespace kinora::tracking
