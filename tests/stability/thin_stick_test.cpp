// A stick about three pixels wide: in a person's hand, and by itself as a rigid thing.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "core/random.h"
#include "core/sensor_noise.h"
#include "ingest/depth/depth_cleaning.h"
#include "tracking/body/limb_poses.h"
#include "tracking/body/person_camera.h"
#include "tracking/deforming/deforming_tracker.h"
#include "tracking/rigid/rigid_tracker.h"
#include "tracking/scenes/seen_errors.h"
#include "tracking/scenes/synthetic_scene.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kHalfLength = 0.30;
constexpr int kFrames = 40;
constexpr testing::PersonCamera kCamera{320, 240, 262.5};

/// A cylinder about its own y axis, so many pixels wide at `distance`.
testing::Shape stick_of(double pixels, double distance, double focal) {
  return {testing::ShapeKind::kCylinder, {pixels / 2 * distance / focal, kHalfLength, 0}, true};
}

/// Draws it, and cleans the depth as every capture's is.
void draw(const testing::Shape& stick, const SE3& to_camera, std::uint8_t label, ingest::Frame& frame) {
  Random random(3, static_cast<std::uint64_t>(frame.index));
  const SE3 to_stick = to_camera.inverse();
  for (int v = 0; v < frame.labels.height(); ++v) {
    for (int u = 0; u < frame.labels.width(); ++u) {
      const Vec ray = to_stick.linear() * frame.camera.intrinsics.unproject(u, v, 1);
      const auto z = testing::intersect(stick, to_stick.translation(), ray);
      float& depth = frame.depth.at(u, v);
      if (!z || (frame.labels.at(u, v) != 0 && depth > 0 && depth < static_cast<float>(*z))) continue;
      depth = static_cast<float>(*z + kSensorNoise.sigma(*z) * random.normal());
      frame.labels.at(u, v) = label;
      const double along = (to_stick.translation() + *z * ray).y();
      for (int c = 0; c < 3; ++c)
        frame.color.at(u, v, c) =
            static_cast<std::uint8_t>(130 + 60 * (std::sin(31 * along) + std::sin(53 * along + 1)) / 1.5);
    }
  }
  frame.clean_depth = ingest::clean_depth(frame.depth, frame.camera.intrinsics);
}

// Metres, of points along the stick, from where they are in the first frame; in the worst frame.
double worst_mean_error(const motion::Motion& motion, const std::vector<SE3>& poses) {
  std::vector<double> sums(poses.size(), 0);
  double count = 0;
  for (double y = -kHalfLength; y <= kHalfLength; y += 0.05, ++count) {
    const auto track = motion::track_point(motion, poses.size(), 0, poses.front() * Vec(0, y, 0));
    for (std::size_t i = 0; i < poses.size(); ++i) sums[i] += (track[i] - poses[i] * Vec(0, y, 0)).norm();
  }
  return *std::max_element(sums.begin(), sums.end()) / count;
}

// The arm goes to and fro by 30 cm, up to 2.4 cm a frame.
testing::DressedPerson person_at(double frame) {
  BodyState state = testing::tall_person();
  const auto from = testing::reaching(kLeftArm, state, {0.40, 0.00, 0.30});
  const auto to = testing::reaching(kLeftArm, state, {0.15, 0.20, 0.35});
  testing::set_limb(kLeftArm, from, to, 0.5 - 0.5 * std::cos(2 * std::numbers::pi * frame / kFrames), state);
  return testing::DressedPerson(state);
}

// In the left hand, upright at first.
SE3 stick_in_hand(double frame) {
  const auto hand = [](double at) { return person_at(at).body().body().bones[kLeftWrist]; };
  SE3 upright = SE3::Identity();
  upright.translation() = hand(0) * Vec(0.08, 0, 0) + Vec(0, -0.2, -0.03);
  return hand(frame) * hand(0).inverse() * upright;
}

struct Followed {
  double stick = 0; ///< metres, as worst_mean_error()
  double arm = 0;   ///< metres, mean of the arm's points while they are seen
};

Followed follow_in_hand(double pixels) {
  const testing::PersonScene scene{"stick", kFrames, person_at, chain_of(kLeftArm).parts};
  const testing::Shape stick = stick_of(pixels, 2.1, kCamera.focal);
  DeformingTracker tracker(1);
  std::vector<SE3> poses;
  for (int i = 0; i < kFrames; ++i) {
    ingest::Frame frame = testing::see_person(scene, i, kCamera);
    poses.push_back(stick_in_hand(i));
    draw(stick, poses.back(), 1, frame);
    EXPECT_EQ(tracker.track(frame).health, motion::Health::kTracked) << i;
  }
  const motion::Motion motion = tracker.motion();
  std::vector<int> numbers(kFrames);
  std::iota(numbers.begin(), numbers.end(), 0);
  return {worst_mean_error(motion, poses),
          testing::seen_errors(testing::track_person(scene, 600, kCamera, scene.fast_parts), motion, numbers).mean};
}

TEST(ThinStick, SixPixelsWideIsFollowedInAHand) {
  const Followed found = follow_in_hand(6);
  EXPECT_LT(found.stick, 0.010); // found: 6.5 mm
  EXPECT_LT(found.arm, 0.012);
}

// Cleaning takes two pixels from either side of a jump, so that nothing of it is measured, and the stick itself is not
// followed (docs/capturing.md says so).
TEST(ThinStick, ThreePixelsWideDoesNotDisturbWhoHoldsIt) { EXPECT_LT(follow_in_hand(3).arm, 0.012); }

// Carried across the view at 1 cm and turned by 1° a frame. How far off it is wherever it is believed, metres.
std::vector<double> errors_of_rigid(double pixels) {
  constexpr double kDistance = 1.0;
  const testing::SceneOptions options;
  const testing::Shape stick = stick_of(pixels, kDistance, options.focal);
  RigidTracker tracker(2);
  const auto pose_of = [&](int i) {
    return testing::pose_at({0.01 * i - 0.2, 0.05 * std::sin(0.2 * i), kDistance}, 0, 0, 30 + i);
  };
  std::vector<double> errors;
  for (int i = 0; i < kFrames; ++i) {
    ingest::Frame frame = testing::grey_frame(SE3::Identity(), i, options);
    for (float& z : frame.depth.values()) z = 4;
    draw(stick, pose_of(i), 2, frame);
    const auto result = tracker.track(frame);
    if (result.pose.health != motion::Health::kTracked) continue;
    double& error = errors.emplace_back(0);
    for (const double y : {-kHalfLength, 0.0, kHalfLength}) {
      const Vec there = result.pose.canonical_to_world * pose_of(0) * Vec(0, y, 0);
      error = std::max(error, (there - pose_of(i) * Vec(0, y, 0)).norm());
    }
  }
  return errors;
}

TEST(ThinStick, TwelvePixelsWideIsFollowedAsARigidThing) {
  const std::vector<double> errors = errors_of_rigid(12);
  EXPECT_EQ(errors.size(), static_cast<std::size_t>(kFrames));
  EXPECT_LT(*std::max_element(errors.begin(), errors.end()), 0.010); // found: 6.6 mm
}

TEST(ThinStick, ThreePixelsWideIsNeverBelievedToBeFound) { EXPECT_TRUE(errors_of_rigid(3).empty()); }

} // namespace
} // namespace kinora::tracking
