// How far an object may jump from one frame to the next, or be somewhere else after it was out of sight.
#include <gtest/gtest.h>

#include "core/random.h"
#include "tracking/rigid/rigid_tracker.h"
#include "tracking/scenes/synthetic_scene.h"

namespace kinora::tracking {
namespace {

using testing::pose_at;
using testing::render_frame;
using testing::SceneOptions;
using testing::Shape;
using testing::ShapeKind;

constexpr double kDegree = 3.14159265358979 / 180;
constexpr int kTrials = 8;

struct Jump {
  double metres;
  double degrees;
  int frames_out_of_sight;
};

struct Outcome {
  int found = 0; ///< within 1 cm and 3°
  int lost = 0;
  int wrong = 0;
};

Eigen::Vector3d random_direction(Random& random) {
  return Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
}

/// An object that is seen four times, and then elsewhere.
Outcome follow(const Shape& shape, const Jump& jump) {
  SceneOptions options;
  options.noise = 1;
  Outcome outcome;
  for (int trial = 0; trial < kTrials; ++trial) {
    Random random(7, static_cast<std::uint64_t>(trial));
    RigidTracker tracker(2);
    const SE3 first = pose_at({0, 0, 1.2}, 25, 30 + 5 * trial);
    int frame = 0;
    for (; frame < 4; ++frame) tracker.track(render_frame(shape, first, SE3::Identity(), frame, options));
    for (int k = 0; k < jump.frames_out_of_sight; ++k, ++frame) {
      tracker.track(render_frame(shape, pose_at({9, 0, 1}, 0, 0), SE3::Identity(), frame, options));
    }
    Eigen::Vector3d direction = random_direction(random);
    direction.z() *= 0.3; // across the view, where a shape slides along itself
    SE3 second = first;
    second.translation() += jump.metres * direction.normalized();
    second.linear() = Eigen::AngleAxisd(jump.degrees * kDegree, random_direction(random)) * first.linear();
    const RigidTrackingResult result = tracker.track(render_frame(shape, second, SE3::Identity(), frame, options));
    const SE3 motion = result.pose.canonical_to_world;
    const double metres = (motion * first.translation() - second.translation()).norm();
    const double angle = rotation_angle(motion.inverse() * second * first.inverse());
    if (result.pose.health != motion::Health::kTracked) {
      ++outcome.lost;
    } else if (metres < 0.01 && angle < 3 * kDegree) {
      ++outcome.found;
    } else {
      ++outcome.wrong;
    }
  }
  return outcome;
}

TEST(RigidObject, IsFollowedOverLargeJumpsByItsTexture) {
  for (const int hidden : {0, 5}) {
    for (const double metres : {0.05, 0.1, 0.2}) {
      for (const double degrees : {5.0, 30.0}) {
        const Outcome outcome = follow({}, {metres, degrees, hidden});
        EXPECT_EQ(outcome.found, kTrials) << metres << " m, " << degrees << " degrees, hidden for " << hidden;
      }
    }
    for (const Jump far : {Jump{0.2, 60, hidden}, Jump{0.4, 30, hidden}, Jump{0.4, 60, hidden}}) {
      const Outcome outcome = follow({}, far); // some show more new sides than known ones
      EXPECT_GE(outcome.found, kTrials - 2) << far.metres << " m, " << far.degrees << " degrees, hidden for " << hidden;
      EXPECT_EQ(outcome.wrong, 0);
    }
  }
}

TEST(RigidObject, IsFollowedOverLargeJumpsByItsSilhouette) {
  const Shape plain{ShapeKind::kBox, {0.12, 0.09, 0.07}, false};
  for (const double metres : {0.05, 0.1, 0.2}) {
    const Outcome outcome = follow(plain, {metres, 5, 0});
    EXPECT_EQ(outcome.found, kTrials) << metres << " m";
  }
  for (const Jump far : {Jump{0.1, 30, 0}, Jump{0.4, 5, 0}}) {
    EXPECT_GE(follow(plain, far).found, kTrials - 2) << far.metres << " m"; // of its sides, some look alike
  }
}

} // namespace
} // namespace kinora::tracking
