#include "core/rolling_shutter.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace kinora {
namespace {

const Intrinsics kCamera{64, 48, 60, 62, 31.5, 23.5};

Twist random_twist(Random& random, double size) {
  Twist twist;
  for (int i = 0; i < 6; ++i) twist[i] = size * (2 * random.uniform_double() - 1);
  return twist;
}

TEST(RollingShutter, RowsAreReadOneAfterTheOtherAroundTheMiddle) {
  EXPECT_NEAR(row_time(0, 48), -0.5 + 0.5 / 48, 1e-15);
  EXPECT_NEAR(row_time(23.5, 48), 0, 1e-15);
  EXPECT_NEAR(row_time(47, 48) + row_time(0, 48), 0, 1e-15);
}

TEST(RollingShutter, ARowsRayIsThatOfACameraWhichHasMovedOn) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const double size = 0.03;
    const Twist readout = random_twist(random, size);
    const double u = 63 * random.uniform_double(), v = 47 * random.uniform_double(), z = 3 * random.uniform_double();
    const RowRay ray = row_ray(kCamera, u, v, readout);
    const Eigen::Vector3d exact = exp_se3(row_time(v, kCamera.height) * readout) * kCamera.unproject(u, v, z);
    EXPECT_LT((ray.origin + z * ray.direction - exact).norm(), 2 * size * size * (1 + z));
  }
}

TEST(RollingShutter, MotionWhileReadingIsThePartOfThatBetweenFrames) {
  Random random(5);
  const Twist velocity = random_twist(random, 1);
  std::vector<SE3> path;
  std::vector<double> times;
  for (const double t : {0.0, 0.03, 0.07, 0.1}) {
    path.push_back(exp_se3(t * velocity));
    times.push_back(t);
  }
  const std::vector<Twist> motion = readout_motion(path, times, 0.02);
  ASSERT_EQ(motion.size(), path.size());
  for (const Twist& twist : motion) EXPECT_LT((twist - 0.02 * velocity).norm(), 1e-9);
}

TEST(RollingShutter, APathThatJumpsIsNoMotion) {
  const Twist velocity = (Twist() << 0.1, 0, 0, 0, 0.2, 0).finished();
  std::vector<SE3> path;
  std::vector<double> times;
  for (int f = 0; f < 8; ++f) {
    const SE3 found_elsewhere = f < 4 ? SE3(SE3::Identity()) : SE3(Eigen::Translation3d(1, 0, 0));
    path.push_back(found_elsewhere * exp_se3(0.03 * f * velocity));
    times.push_back(0.03 * f);
  }
  for (const Twist& twist : readout_motion(path, times, 0.02)) EXPECT_LT((twist - 0.02 * velocity).norm(), 1e-9);
}

TEST(RollingShutter, ACameraOfOnePoseDoesNotMove) {
  const std::vector<SE3> path{SE3::Identity()};
  const std::vector<double> times{0};
  EXPECT_TRUE(readout_motion(path, times, 0.02).front().isZero(0));
}

} // namespace
} // namespace kinora
