#include "tracking/camera/depth_lag.h"

#include <gtest/gtest.h>

#include "core/velocity.h"
#include "tracking/camera/camera_tracker.h"
#include "tracking/scenes/room_scene.h"

namespace kinora::tracking {
namespace {

using testing::pose_at;
using testing::render_room;

constexpr double kSecondsPerFrame = 1.0 / 30;

// A hand that carries the camera along and looks about, at a time in frames.
SE3 hand(double t) {
  return pose_at({0.25 * std::sin(0.12 * t), 0.1 * std::sin(0.2 * t), 0.15 * (1 - std::cos(0.1 * t))},
                 4 * std::sin(0.15 * t), 15 * std::sin(0.1 * t), 3 * std::sin(0.2 * t));
}

/// Frames of a camera that moves so, whose depth is that of `lag` seconds before.
std::optional<double> lag_found(double lag, int frames, SE3 (*camera)(double)) {
  CameraTracker tracker;
  for (int i = 0; i < frames; ++i) {
    ingest::Frame frame = render_room(camera(i), i);
    const ingest::Frame before = render_room(camera(i - lag / kSecondsPerFrame), i);
    frame.depth = before.depth;
    frame.clean_depth = before.clean_depth;
    tracker.track(frame);
  }
  return tracker.depth_lag();
}

class DepthLag : public ::testing::TestWithParam<double> {};

TEST_P(DepthLag, IsFoundFromHowACameraInAHandMoves) {
  const auto found = lag_found(GetParam(), 100, hand);
  ASSERT_TRUE(found);
  EXPECT_NEAR(*found, GetParam(), 0.002 + 0.1 * std::abs(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(DepthLag, DepthLag, ::testing::Values(-0.03, -0.01, 0.01, 0.03));

TEST(DepthLag, IsNoneWhereDepthAndColourAreOfOneMoment) { EXPECT_FALSE(lag_found(0, 100, hand)); }

TEST(DepthLag, OfAStillCameraCannotBeTold) {
  EXPECT_FALSE(lag_found(0.03, 70, [](double) { return SE3(SE3::Identity()); }));
}

TEST(DepthLag, OfAFewFramesCannotBeTold) { EXPECT_FALSE(lag_found(0.03, 30, hand)); }

TEST(DepthLag, IsToldOnlyIfStretchesOfTheCaptureAgree) {
  std::vector<SE3> path;
  std::vector<double> times;
  for (int i = 0; i < 80; ++i) {
    path.push_back(hand(i));
    times.push_back(i * kSecondsPerFrame);
  }
  const auto told = [&](double early, double late) {
    std::vector<LagEvidence> evidence;
    for (std::size_t i = 1; i + 1 < path.size(); ++i) { // against a key frame that was taken at rest
      DepthAgainstTexture measured;
      measured.difference = (i < 40 ? early : late) * velocity_between(path[i - 1], path[i + 1], 2 * kSecondsPerFrame);
      measured.certainty.setIdentity();
      evidence.push_back({i, 0, SE3::Identity(), measured});
    }
    std::vector<SE3> at_rest = path;
    at_rest[0] = at_rest[1];
    return estimate_depth_lag(evidence, at_rest, times);
  };
  const auto agreed = told(0.02, 0.021);
  ASSERT_TRUE(agreed);
  EXPECT_NEAR(*agreed, 0.0205, 0.0006);
  EXPECT_FALSE(told(0.02, 0.005));
}

TEST(DepthLag, CarriesDepthToWhereTheColourCameraStandsByThen) {
  const double lag = 0.03;
  const double t = 20;
  const SE3 color = hand(t);
  const SE3 depth = hand(t - lag / kSecondsPerFrame);
  const Twist velocity = velocity_between(hand(t - 1), hand(t + 1), 2 * kSecondsPerFrame);
  const SE3 off = color.inverse() * depth * depth_to_color(lag, velocity).inverse();
  EXPECT_LT(off.translation().norm(), 0.1 * (color.inverse() * depth).translation().norm());
  EXPECT_LT(rotation_angle(off), 0.1 * rotation_angle(color.inverse() * depth));
}

} // namespace
} // namespace kinora::tracking
