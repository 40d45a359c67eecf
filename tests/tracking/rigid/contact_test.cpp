#include "tracking/rigid/contact.h"

#include <gtest/gtest.h>

#include "motion/point_track.h"
#include "tracking/deforming/deforming_tracker.h"
#include "tracking/scenes/bending_plate.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;
using testing::Plate;
using testing::pose_at;

/// A thing of one point, at the origin of its own space.
const std::vector<SurfacePoint>& one_point() {
  static const std::vector<SurfacePoint> surface = {{Eigen::Vector3f::Zero(), Eigen::Vector3f::UnitZ(), 0, 1}};
  return surface;
}

NearbyObject thing_at(const SE3& pose) { return {2, pose, one_point(), Vec::Zero()}; }

// Carried about, turned a little in each frame.
SE3 moving_pose(int frame) { return pose_at({0.01 * frame, 0, 1}, 0, 2 * frame, 0); }

// Ten frames that show a place, `beside` the thing in the first and moved on as `path` says.
template <class Path> ContactTracker after_ten_frames(const Path& path, const ContactConfig& config = {}) {
  ContactTracker contact(config);
  for (int i = 0; i < 10; ++i) {
    const NearbyObject thing = thing_at(moving_pose(i));
    const std::vector<Vec> positions = {path(i)};
    const std::vector<double> seen = {1};
    contact.update({&thing, 1}, positions, seen);
  }
  return contact;
}

std::optional<Vec> position_at(const ContactTracker& contact, int frame) {
  const NearbyObject thing = thing_at(moving_pose(frame));
  return contact.position_of(0, {&thing, 1});
}

TEST(ContactTracker, WhatGoesAlongWithAnObjectGoesOnWithIt) {
  const Vec beside(0.03, 0, 0);
  const ContactTracker contact = after_ten_frames([&](int i) { return Vec(moving_pose(i) * beside); });
  const auto position = position_at(contact, 30);
  ASSERT_TRUE(position);
  EXPECT_LT((*position - moving_pose(30) * beside).norm(), 1e-9);
}

TEST(ContactTracker, WhatStandsStillOrIsFarAwayHoldsNothing) {
  EXPECT_FALSE(position_at(after_ten_frames([](int) { return Vec(0.03, 0, 1); }), 30));
  EXPECT_FALSE(position_at(after_ten_frames([](int i) { return Vec(moving_pose(i) * Vec(0.3, 0, 0)); }), 30));
}

TEST(ContactTracker, WhatIsLetGoIsNotHeldAnyMore) {
  ContactTracker contact = after_ten_frames([](int i) { return Vec(moving_pose(i) * Vec(0.03, 0, 0)); });
  EXPECT_TRUE(position_at(contact, 10));
  const std::vector<Vec> positions = {moving_pose(9) * Vec(0.03, 0.1, 0)};
  const std::vector<double> seen = {1};
  const NearbyObject thing = thing_at(moving_pose(10));
  contact.update({&thing, 1}, positions, seen);
  EXPECT_FALSE(position_at(contact, 11));
}

TEST(ContactTracker, WhatIsNotSeenTeachesNothing) {
  ContactTracker contact = after_ten_frames([](int i) { return Vec(moving_pose(i) * Vec(0.03, 0, 0)); });
  const std::vector<Vec> positions = {Vec(1, 1, 1)};
  const std::vector<double> seen = {0};
  const NearbyObject thing = thing_at(moving_pose(10));
  contact.update({&thing, 1}, positions, seen);
  EXPECT_LT((*position_at(contact, 11) - moving_pose(11) * Vec(0.03, 0, 0)).norm(), 1e-9);
}

TEST(ContactTracker, AnObjectThatIsNotFoundHoldsNothing) {
  const ContactTracker contact = after_ten_frames([](int i) { return Vec(moving_pose(i) * Vec(0.03, 0, 0)); });
  EXPECT_FALSE(contact.position_of(0, {}));
  EXPECT_TRUE(contact.is_in_contact(0, 2));
  EXPECT_FALSE(contact.is_in_contact(0, 3));
  EXPECT_FALSE(contact.is_in_contact(1, 2));
}

TEST(ContactTracker, WhereHoldingIsPresumedNearnessIsEnough) {
  const auto still = [](int) { return Vec(moving_pose(0) * Vec(0.1, 0, 0)); };
  const auto presumed = [&](double reach) {
    ContactTracker contact({.reach = reach, .assumes_contact = true});
    const NearbyObject thing = thing_at(moving_pose(0));
    const std::vector<Vec> positions = {still(0)};
    const std::vector<double> seen = {1};
    for (int i = 0; i < 3; ++i) contact.update({&thing, 1}, positions, seen);
    return position_at(contact, 5).has_value();
  };
  EXPECT_TRUE(presumed(0.2));
  EXPECT_FALSE(presumed(0.05));
  EXPECT_FALSE(position_at(after_ten_frames(still, {.reach = 0.2, .assumes_contact = true}),
                           30)); // the thing went on without it
}

// A plate bends all the time; its left end holds a thing. From the tenth frame on a cover hides the left half of the
// plate, and the thing goes 18 cm away.
constexpr int kFrames = 20;
constexpr double kEnd = -0.22;

Plate holding_plate(int frame) {
  Plate plate;
  plate.to_world = SE3(Eigen::Translation3d(0, 0, 1));
  plate.curvature = frame < 10 ? 0.4 * frame : 4 - 0.8 * (frame - 10);
  return plate;
}

SE3 end_of(const Plate& plate) {
  return SE3(Eigen::Translation3d(plate.position(kEnd, 0)) * Eigen::AngleAxisd(-plate.curvature * kEnd, Vec::UnitY()));
}

// Error of the plate's end in the last frame, metres.
double error_of_end(bool with_thing) {
  testing::SceneOptions options;
  options.noise = 1;
  options.width = 160;
  options.height = 120;
  options.focal = 160;
  DeformingTracker tracker(2);
  for (int i = 0; i < kFrames; ++i) {
    options.occluded_columns = i < 10 ? 0 : 73;
    NearbyObject thing = thing_at(end_of(holding_plate(i)) * Eigen::Translation3d(0, 0, 0.03));
    thing.label = 3;
    const auto frame = render_plate(holding_plate(i), SE3::Identity(), i, options);
    tracker.track(frame, std::span(&thing, with_thing ? 1 : 0));
  }
  const auto track = motion::track_point(tracker.motion(), kFrames, 0, holding_plate(0).position(kEnd, 0));
  return (track.back() - holding_plate(kFrames - 1).position(kEnd, 0)).norm();
}

TEST(DeformingTrackerWithObjects, WhatIsHiddenGoesWithTheThingThatItHolds) {
  const double without = error_of_end(false);
  const double with = error_of_end(true);
  EXPECT_GT(without, 0.05);
  EXPECT_LT(with, 0.7 * without); // 41 mm of 67 mm
}

} // namespace
} // namespace kinora::tracking
