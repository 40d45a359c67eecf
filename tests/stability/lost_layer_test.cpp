// A bending thing without bones leaves the view and comes back elsewhere, bent and turned as it was long before.
#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>

#include "motion/point_track.h"
#include "tracking/deforming/deforming_tracker.h"
#include "tracking/scenes/bending_plate.h"

namespace kinora::tracking {
namespace {

using testing::Plate;

constexpr int kBefore = 30;
constexpr int kAway = 10;
constexpr int kAfter = 6;

// Bent and turned, then flat and frontal; away; and back as in the first frames, but elsewhere.
Plate plate_at(int frame, double degrees) {
  const bool is_back = frame >= kBefore + kAway;
  const double t = is_back ? 0 : std::min(1.0, std::max(0, frame - 4) / (kBefore - 6.0));
  Plate plate;
  plate.curvature = 4 * (1 - t);
  const double rotation = degrees * (1 - t) * std::numbers::pi / 180;
  const Eigen::Vector3d position = is_back ? Eigen::Vector3d(0.15, 0.06, 1.1) : Eigen::Vector3d(-0.1, 0, 1);
  plate.to_world =
      SE3(Eigen::Translation3d(position) * Eigen::AngleAxisd(rotation, Eigen::Vector3d(0, 0.3, 1).normalized()));
  return plate;
}

ingest::Frame frame_at(int frame, double degrees) {
  testing::SceneOptions options;
  options.noise = 1;
  options.width = 160;
  options.height = 120;
  options.focal = 130;
  Plate plate = plate_at(frame, degrees);
  if (frame >= kBefore && frame < kBefore + kAway) plate.to_world.translation().x() += 10;
  return testing::render_plate(plate, SE3::Identity(), frame, options);
}

class LostLayer : public ::testing::TestWithParam<int> {};

// Without what is remembered of poses it is 20 cm off, or more.
TEST_P(LostLayer, IsFoundAgainBentAndTurnedAsBefore) {
  constexpr int kCount = kBefore + kAway + kAfter;
  DeformingTrackerConfig config;
  config.binding.use_body = false;
  DeformingTracker tracker(2, config);
  for (int i = 0; i < kCount; ++i) {
    const auto result = tracker.track(frame_at(i, GetParam()));
    if (i < kBefore || i == kCount - 1) {
      EXPECT_EQ(result.health, motion::Health::kTracked) << i;
    }
  }
  const motion::Motion motion = tracker.motion();
  double sum = 0;
  int count = 0;
  for (double x = -0.2; x < 0.21; x += 0.08) {
    for (double y = -0.15; y < 0.16; y += 0.06) {
      const auto track = motion::track_point(motion, kCount, 0, plate_at(0, GetParam()).position(x, y));
      sum += (track.back() - plate_at(kCount - 1, GetParam()).position(x, y)).norm();
      ++count;
    }
  }
  EXPECT_LT(sum / count, 0.01);
}
INSTANTIATE_TEST_SUITE_P(Turns, LostLayer, ::testing::Values(90, 160));

} // namespace
} // namespace kinora::tracking
