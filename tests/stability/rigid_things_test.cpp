// Things that people handle (tests/tracking/scenes/thing_scenes.h): what turns unseen is said, and what was hidden is
// found.
#include <numbers>

#include <gtest/gtest.h>

#include "tracking/rigid/rigid_tracker.h"
#include "tracking/scenes/thing_scenes.h"

namespace kinora::tracking {
namespace {

using testing::MovingThing;
using testing::see_things;
using testing::thing_scene;
using testing::ThingCamera;
using testing::ThingScene;

// How much of a turn about the axis lies in the weak directions: 1 is all.
double degenerate_share(const RigidTrackingResult& result, const Eigen::Vector3d& axis) {
  double share = 0;
  for (const Twist& degenerate : result.degenerate) {
    const double along = degenerate.tail<3>().dot(axis);
    share += along * along;
  }
  return share;
}

TEST(RigidThings, APlainVaseWhoseHandleIsHiddenMayTurnAboutItsAxis) {
  const ThingScene& scene = thing_scene("vase_slow");
  const MovingThing& vase = scene.things[0];
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    SCOPED_TRACE(seed);
    ThingCamera camera;
    camera.seed = seed;
    RigidTracker tracker(vase.label);
    for (int i = 0; i < 14; ++i) {
      const RigidTrackingResult result = tracker.track(see_things(scene, i, camera));
      ASSERT_EQ(result.pose.health, motion::Health::kTracked) << "frame " << i;
      if (i < 4) continue; // a little of the handle still stands out
      EXPECT_EQ(result.degenerate_directions, 1) << "frame " << i;
      EXPECT_GT(degenerate_share(result, vase.pose(i).linear().col(1)), 0.5) << "frame " << i;
    }
  }
}

TEST(RigidThings, WhatComesOutFromBehindAnotherIsFoundWhereItsMotionLed) {
  const ThingScene& scene = thing_scene("swap");
  const MovingThing& hidden = scene.things[1];
  RigidTracker tracker(hidden.label);
  constexpr int kFirst = 26;
  for (int i = kFirst; i < 42; ++i) { // 21 of its pixels are seen in frame 35
    const RigidTrackingResult result = tracker.track(see_things(scene, i));
    if (i == 35) continue;
    ASSERT_EQ(result.pose.health, motion::Health::kTracked) << "frame " << i;
    const SE3 found = result.pose.canonical_to_world * hidden.pose(kFirst);
    EXPECT_LT((found.translation() - hidden.pose(i).translation()).norm(), 0.005) << "frame " << i;
  }
}

// Half a pixel at its widest is 1.2 degrees.
TEST(RigidThings, AGlossyPrintIsFollowedToHalfAPixelOnTheMean) {
  const ThingScene& scene = thing_scene("vase_printed");
  const MovingThing& vase = scene.things[0];
  ThingCamera camera;
  camera.seed = 2;
  RigidTracker tracker(vase.label);
  constexpr int kFrames = 21;
  double sum = 0;
  for (int i = 0; i < kFrames; ++i) {
    const RigidTrackingResult result = tracker.track(see_things(scene, i, camera));
    ASSERT_EQ(result.pose.health, motion::Health::kTracked) << "frame " << i;
    sum += rotation_angle((result.pose.canonical_to_world * vase.pose(0)).inverse() * vase.pose(i));
  }
  EXPECT_LT(sum / kFrames * 180 / std::numbers::pi, 1.2);
}

} // namespace
} // namespace kinora::tracking
