#include "tracking/body/body_tracker.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "tracking/body/synthetic_body.h"

namespace kinora::tracking {
namespace {

using testing::BodyScene;
using testing::joint_distance;
using testing::mean_joint_distance;
using testing::render_body;
using testing::standing;

constexpr double kInterval = 1.0 / 30;

void set(BodyState& state, Joint joint, const Eigen::Vector3d& angles) {
  const int count = joints()[joint].angle_count;
  state.pose.angles.segment(joints()[joint].first_angle, count) = angles.head(count);
}

// Turns about itself, waves with the left arm, swings the right one, walks on the spot.
BodyState dancing(int frame, double degrees_per_frame, double height = 1.75) {
  const double t = frame * kInterval;
  BodyState state = standing(degrees_per_frame * frame, height);
  state.shape[kThighGirth] = 0.1;
  state.shape[kShoulderWidth] = 0.04;
  set(state, kLeftShoulder, {0.2, -0.3 + 0.3 * std::sin(3 * t), 0.4 * std::sin(2 * t)});
  set(state, kLeftElbow, {1.0 + 0.6 * std::sin(5 * t), 0, 0});
  set(state, kRightShoulder, {0, 0.4 * std::sin(4 * t), 1.1});
  set(state, kLeftHip, {-0.3 - 0.3 * std::sin(4 * t), 0, 0.05});
  set(state, kLeftKnee, {0.4 + 0.3 * std::sin(4 * t), 0, 0});
  return state;
}

LayerView view_of(const BodyState& state, int frame, const BodyScene& scene = {}) {
  BodyScene noisy = scene;
  noisy.seed = static_cast<std::uint64_t>(frame);
  return view_label(render_body(state, noisy), 1);
}

TEST(BodyTracker, FollowsSomebodyWhoTurnsAllTheWayRound) {
  BodyTracker tracker;
  for (int i = 0; i < 60; ++i) {
    const BodyState truth = dancing(i, 6);
    const auto result = tracker.track(view_of(truth, i), SE3::Identity(), i * kInterval);
    EXPECT_EQ(result.health, motion::Health::kTracked) << i;
    EXPECT_LT(mean_joint_distance(tracker.state(), truth), 0.03) << i;
  }
}

// The left forearm and hand are behind something for a second, and come out elsewhere.
TEST(BodyTracker, FindsAHandThatComesOutOfHiding) {
  BodyScene covered;
  covered.cover = testing::Cover{122, 60, 160, 130};
  BodyTracker tracker;
  for (int i = 0; i < 20; ++i) {
    BodyState truth = standing(0);
    const bool hidden = i < 12;
    set(truth, kLeftShoulder, hidden ? Eigen::Vector3d(0, -0.2, -1.2) : Eigen::Vector3d(0, -0.2, 0.3));
    set(truth, kLeftElbow, {hidden ? 1.0 : 1.3, 0, 0});
    const auto result =
        tracker.track(view_of(truth, i, hidden ? covered : BodyScene()), SE3::Identity(), i * kInterval);
    if (hidden) {
      EXPECT_EQ(result.limbs[kLeftArm], LimbHealth::kHidden) << i;
      EXPECT_LT(joint_distance(tracker.state(), truth, kLeftElbow), 0.15) << i;
    } else if (i >= 13) {
      EXPECT_EQ(result.limbs[kLeftArm], LimbHealth::kSeen) << i;
      EXPECT_LT(joint_distance(tracker.state(), truth, kLeftWrist), 0.06) << i;
    }
  }
}

TEST(BodyTracker, StaysWhereItIsWhileNothingIsSeen) {
  BodyTracker tracker;
  tracker.track(view_of(dancing(0, 0), 0), SE3::Identity(), 0);
  tracker.track(view_of(dancing(1, 0), 1), SE3::Identity(), kInterval);
  const BodyState before = tracker.state();
  for (int i = 2; i < 5; ++i) {
    const auto result = tracker.track(LayerView(), SE3::Identity(), i * kInterval);
    EXPECT_EQ(result.health, motion::Health::kHeld);
  }
  EXPECT_EQ(mean_joint_distance(before, tracker.state()), 0);
}

TEST(BodyTracker, IsNotStartedByAnEmptyView) {
  BodyTracker tracker;
  EXPECT_EQ(tracker.track(LayerView(), SE3::Identity(), 0).health, motion::Health::kLost);
  EXPECT_FALSE(tracker.started());
}

// Only a shoulder is left of the person: most freedoms have no evidence at all.
TEST(BodyTracker, StaysFiniteWithHardlyAnyEvidence) {
  BodyTracker tracker;
  BodyScene scene;
  tracker.track(view_of(dancing(0, 0), 0), SE3::Identity(), 0);
  scene.cover = testing::Cover{0, 60, scene.width, scene.height};
  for (int i = 1; i < 5; ++i) {
    tracker.track(view_of(dancing(i, 0), i, scene), SE3::Identity(), i * kInterval);
    EXPECT_TRUE(tracker.state().pose.root.matrix().allFinite());
    EXPECT_TRUE(tracker.state().pose.angles.allFinite());
    EXPECT_TRUE(tracker.state().shape.allFinite());
    EXPECT_LT(mean_joint_distance(tracker.state(), dancing(i, 0)), 0.15);
  }
}

TEST(BodyTracker, KeepsAnglesNearTheirLimits) {
  BodyState state = standing(0);
  set(state, kLeftElbow, {-1.0, 0, 0}); // overstretched
  BodyPrior prior;
  prior.state = state;
  LayerView nothing = view_of(standing(0), 0);
  BodyEvidence evidence = gather_evidence(nothing, 100, {});
  evidence.points.clear();
  minimise(evidence, prior, {}, 20, false, state);
  EXPECT_GT(state.pose.angles[joints()[kLeftElbow].first_angle], -0.05);
}

// Two frames with one thread and with two, a kilometre from the world's origin and at it.
TEST(BodyTracker, NeitherThreadsNorThePlaceInTheWorldMatter) {
  const auto run = [](int threads, const SE3& camera_to_world) {
    set_thread_count(threads);
    BodyTracker tracker;
    for (int i = 0; i < 3; ++i) tracker.track(view_of(dancing(i, 1), i), camera_to_world, i * kInterval);
    set_thread_count(0);
    return tracker.state();
  };
  const BodyState one = run(1, SE3::Identity());
  const BodyState two = run(2, SE3::Identity());
  EXPECT_EQ((one.pose.root.matrix() - two.pose.root.matrix()).norm(), 0);
  EXPECT_EQ((one.pose.angles - two.pose.angles).norm(), 0);
  EXPECT_EQ((one.shape - two.shape).norm(), 0);
  SE3 far = SE3::Identity();
  far.translation() = Eigen::Vector3d(1000, 1000, -1000);
  BodyState away = run(2, far);
  away.pose.root = far.inverse() * away.pose.root;
  EXPECT_LT(mean_joint_distance(one, away), 1e-6);
}

} // namespace
} // namespace kinora::tracking
