#include "motion/motion.h"

#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/se3.h"

namespace kinora::motion {
namespace {

SE3 turned_about_x(const Eigen::Vector3d& centre, double degrees) {
  return Eigen::Translation3d(centre) * Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Eigen::Vector3d::UnitX());
}

Motion two_poses() {
  std::vector<Motion::Pose> poses(2);
  poses[0].canonical_to_world = turned_about_x({1, 2, 3}, 10);
  poses[1].canonical_to_world = turned_about_x({2, 2, 3}, 50);
  poses[1].health = Health::kHeld;
  return Motion::rigid(poses);
}

TEST(Motion, OfAStillLayerIsIdentityAndTracked) {
  const Motion motion = Motion::still();
  EXPECT_TRUE(motion.canonical_to_world(17.5).isApprox(SE3::Identity()));
  EXPECT_EQ(motion.health(17), Health::kTracked);
}

TEST(Motion, ReturnsTheGivenPosesAtWholeFrames) {
  const Motion motion = two_poses();
  EXPECT_TRUE(motion.canonical_to_world(0).isApprox(motion.poses()[0].canonical_to_world, 1e-15));
  EXPECT_TRUE(motion.canonical_to_world(1).isApprox(motion.poses()[1].canonical_to_world, 1e-15));
  EXPECT_EQ(motion.health(0), Health::kTracked);
  EXPECT_EQ(motion.health(1), Health::kHeld);
}

TEST(Motion, TurnsHalfWayBetweenTwoFrames) {
  const Motion motion = two_poses();
  const SE3 first = motion.canonical_to_world(0);
  EXPECT_NEAR(rotation_angle(first.inverse() * motion.canonical_to_world(0.5)),
              rotation_angle(first.inverse() * motion.canonical_to_world(1)) / 2, 1e-12);
}

TEST(Motion, IsClampedOutsideItsFrames) {
  const Motion motion = two_poses();
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(motion.canonical_to_world(-infinity).isApprox(motion.canonical_to_world(0)));
  EXPECT_TRUE(motion.canonical_to_world(infinity).isApprox(motion.canonical_to_world(1)));
  EXPECT_TRUE(motion.canonical_to_world(std::numeric_limits<double>::quiet_NaN()).matrix().allFinite());
  EXPECT_EQ(motion.health(1000), Health::kHeld);
}

TEST(Motion, RejectsARigidLayerWithoutPoses) { EXPECT_THROW(Motion::rigid({}), Error); }

} // namespace
} // namespace kinora::motion
