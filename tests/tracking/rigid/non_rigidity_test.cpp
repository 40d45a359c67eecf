#include "tracking/rigid/non_rigidity.h"

#include <gtest/gtest.h>

#include "tracking/rigid/rigid_tracker.h"
#include "tracking/scenes/bending_plate.h"

namespace kinora::tracking {
namespace {

using testing::Plate;
using testing::pose_at;
using testing::SceneOptions;

// What is found of a plate in thirty frames, carried about meanwhile.
template <class Curvature> std::optional<NonRigidity> non_rigidity_of(const Curvature& curvature, double noise = 1) {
  SceneOptions options;
  options.noise = noise;
  options.width = 160;
  options.height = 120;
  options.focal = 160;
  RigidTracker tracker(2);
  for (int i = 0; i < 30; ++i) {
    Plate plate;
    plate.to_world = pose_at({0.005 * i, 0, 1}, 10, 5 + 0.5 * i);
    plate.curvature = curvature(i);
    tracker.track(render_plate(plate, SE3::Identity(), i, options));
  }
  return tracker.non_rigidity();
}

TEST(NonRigidityTest, APlateThatSwingsBends) {
  // Its sides go 6, 11 and 2 cm to and fro.
  for (const auto& [most, speed] : {std::pair(2.0, 0.3), std::pair(3.5, 0.6), std::pair(0.7, 0.3)}) {
    SCOPED_TRACE(most);
    const auto non_rigidity =
        non_rigidity_of([most = most, speed = speed](int i) { return most * std::sin(speed * i); });
    ASSERT_TRUE(non_rigidity);
    EXPECT_GT(non_rigidity->metres, 0.014);
    EXPECT_LT(non_rigidity->metres, 0.1);
    EXPECT_LT(non_rigidity->first_frame, 20U);
  }
}

TEST(NonRigidityTest, APlateThatIsBentSlowlyBends) {
  const auto non_rigidity = non_rigidity_of([](int i) { return 0.1 * i; });
  ASSERT_TRUE(non_rigidity);
  EXPECT_GT(non_rigidity->first_frame, 4U);
}

TEST(NonRigidityTest, APlateThatKeepsItsShapeDoesNotBend) {
  for (const double curvature : {0.0, 2.0}) {
    SCOPED_TRACE(curvature);
    for (const double noise : {1.0, 3.0}) EXPECT_FALSE(non_rigidity_of([=](int) { return curvature; }, noise));
  }
}

// A slab of 10 × 14 cm, as a hand, moves about 3 cm before a plate and has its label.
TEST(NonRigidityTest, AHandThatIsTakenForPartOfTheThingDoesNotBendIt) {
  SceneOptions options;
  options.noise = 1;
  RigidTracker tracker(2);
  for (int i = 0; i < 40; ++i) {
    Plate plate;
    plate.to_world = pose_at({0.003 * i, 0, 1}, 10, 5 + 0.5 * i);
    Plate hand;
    hand.half_width = 0.05;
    hand.half_height = 0.07;
    hand.to_world = plate.to_world * Eigen::Translation3d(0.15 * std::sin(0.2 * i), 0.05, -0.03);
    ingest::Frame frame = render_plate(plate, SE3::Identity(), i, options);
    if (i >= 5) {
      const ingest::Frame in_front = render_plate(hand, SE3::Identity(), i + 100, options);
      for (std::size_t k = 0; k < frame.labels.pixel_count(); ++k) {
        if (in_front.labels.values()[k] == 0) continue;
        frame.labels.values()[k] = 2;
        frame.depth.values()[k] = in_front.depth.values()[k];
        for (std::size_t c = 0; c < 3; ++c) frame.color.data()[3 * k + c] = 220;
      }
      frame.clean_depth = frame.depth;
    }
    EXPECT_EQ(tracker.track(frame).pose.health, motion::Health::kTracked) << i;
  }
  EXPECT_FALSE(tracker.non_rigidity());
}

TEST(NonRigidityTest, AFewFramesAreNotEnough) {
  NonRigidityTest evidence;
  for (std::size_t i = 0; i < 40; ++i) evidence.add(i, {i % 10 < 4 ? 0.3 : 0.0, 0.05});
  EXPECT_FALSE(evidence.non_rigidity());
  for (std::size_t i = 40; i < 45; ++i) evidence.add(i, {0.3, 0.02 + 0.001 * static_cast<double>(i)});
  ASSERT_TRUE(evidence.non_rigidity());
  EXPECT_EQ(evidence.non_rigidity()->first_frame, 40U);
  EXPECT_DOUBLE_EQ(evidence.non_rigidity()->metres, 0.064);
}

} // namespace
} // namespace kinora::tracking
