#include "tracking/rigid/interaction.h"

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
SE3 carried(int frame) { return pose_at({0.01 * frame, 0, 1}, 0, 2 * frame, 0); }

// Ten frames that show a place, `beside` the thing in the first and moved on as `path` says.
template <class Path> Interaction after_ten_frames(const Path& path, const InteractionConfig& config = {}) {
  Interaction interaction(config);
  for (int i = 0; i < 10; ++i) {
    const NearbyObject thing = thing_at(carried(i));
    const std::vector<Vec> places = {path(i)};
    const std::vector<double> seen = {1};
    interaction.learn({&thing, 1}, places, seen);
  }
  return interaction;
}

std::optional<Vec> place_at(const Interaction& interaction, int frame) {
  const NearbyObject thing = thing_at(carried(frame));
  return interaction.place_of(0, {&thing, 1});
}

TEST(Interaction, WhatGoesAlongWithAnObjectGoesOnWithIt) {
  const Vec beside(0.03, 0, 0);
  const Interaction interaction = after_ten_frames([&](int i) { return Vec(carried(i) * beside); });
  const auto place = place_at(interaction, 30);
  ASSERT_TRUE(place);
  EXPECT_LT((*place - carried(30) * beside).norm(), 1e-9);
}

TEST(Interaction, WhatStandsStillOrIsFarAwayHoldsNothing) {
  EXPECT_FALSE(place_at(after_ten_frames([](int) { return Vec(0.03, 0, 1); }), 30));
  EXPECT_FALSE(place_at(after_ten_frames([](int i) { return Vec(carried(i) * Vec(0.3, 0, 0)); }), 30));
}

TEST(Interaction, WhatIsLetGoIsNotHeldAnyMore) {
  Interaction interaction = after_ten_frames([](int i) { return Vec(carried(i) * Vec(0.03, 0, 0)); });
  EXPECT_TRUE(place_at(interaction, 10));
  const std::vector<Vec> places = {carried(9) * Vec(0.03, 0.1, 0)};
  const std::vector<double> seen = {1};
  const NearbyObject thing = thing_at(carried(10));
  interaction.learn({&thing, 1}, places, seen);
  EXPECT_FALSE(place_at(interaction, 11));
}

TEST(Interaction, WhatIsNotSeenTeachesNothing) {
  Interaction interaction = after_ten_frames([](int i) { return Vec(carried(i) * Vec(0.03, 0, 0)); });
  const std::vector<Vec> places = {Vec(1, 1, 1)};
  const std::vector<double> seen = {0};
  const NearbyObject thing = thing_at(carried(10));
  interaction.learn({&thing, 1}, places, seen);
  EXPECT_LT((*place_at(interaction, 11) - carried(11) * Vec(0.03, 0, 0)).norm(), 1e-9);
}

TEST(Interaction, AnObjectThatIsNotFoundHoldsNothing) {
  const Interaction interaction = after_ten_frames([](int i) { return Vec(carried(i) * Vec(0.03, 0, 0)); });
  EXPECT_FALSE(interaction.place_of(0, {}));
  EXPECT_TRUE(interaction.holds(0, 2));
  EXPECT_FALSE(interaction.holds(0, 3));
  EXPECT_FALSE(interaction.holds(1, 2));
}

TEST(Interaction, WhereHoldingIsPresumedNearnessIsEnough) {
  const auto still = [](int) { return Vec(carried(0) * Vec(0.1, 0, 0)); };
  const auto presumed = [&](double reach) {
    Interaction interaction({.reach = reach, .presumes = true});
    const NearbyObject thing = thing_at(carried(0));
    const std::vector<Vec> places = {still(0)};
    const std::vector<double> seen = {1};
    for (int i = 0; i < 3; ++i) interaction.learn({&thing, 1}, places, seen);
    return place_at(interaction, 5).has_value();
  };
  EXPECT_TRUE(presumed(0.2));
  EXPECT_FALSE(presumed(0.05));
  EXPECT_FALSE(place_at(after_ten_frames(still, {.reach = 0.2, .presumes = true}), 30)); // the thing went on without it
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
  return SE3(Eigen::Translation3d(plate.place(kEnd, 0)) * Eigen::AngleAxisd(-plate.curvature * kEnd, Vec::UnitY()));
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
  const auto track = motion::track_point(tracker.motion(), kFrames, 0, holding_plate(0).place(kEnd, 0));
  return (track.back() - holding_plate(kFrames - 1).place(kEnd, 0)).norm();
}

TEST(DeformingTrackerWithObjects, WhatIsHiddenGoesWithTheThingThatItHolds) {
  const double without = error_of_end(false);
  const double with = error_of_end(true);
  EXPECT_GT(without, 0.05);
  EXPECT_LT(with, 0.7 * without); // 41 mm of 67 mm
}

} // namespace
} // namespace kinora::tracking
