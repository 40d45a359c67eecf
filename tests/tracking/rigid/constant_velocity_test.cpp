#include "tracking/rigid/constant_velocity.h"

#include <gtest/gtest.h>

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

SE3 rotated(double radians, const Vec& to) {
  SE3 pose(Eigen::AngleAxisd(radians, Vec(1, 2, 3).normalized()));
  pose.translation() = to;
  return pose;
}

TEST(ConstantVelocity, CountsStepsByTime) {
  EXPECT_DOUBLE_EQ(steps_ahead(1.0, 1.5, 2.0), 1);
  EXPECT_DOUBLE_EQ(steps_ahead(1.0, 1.5, 1.75), 0.5);
  EXPECT_DOUBLE_EQ(steps_ahead(1.0, 1.5, 9.0), 3);
  EXPECT_DOUBLE_EQ(steps_ahead(1.0, 1.0, 2.0), 1);
}

TEST(ConstantVelocity, RepeatsTheMotionAboutThePivot) {
  const Vec pivot(0.1, -0.2, 0.3);
  // The pivot goes from (0, 0, 1) to (0.02, 0, 1), and the thing turns about it.
  SE3 earlier = rotated(0.1, Vec::Zero());
  earlier.translation() = Vec(0, 0, 1) - earlier.linear() * pivot;
  SE3 last = rotated(0.2, Vec::Zero());
  last.translation() = Vec(0.02, 0, 1) - last.linear() * pivot;
  const SE3 next = extrapolated(earlier, last, pivot, 0.5);
  EXPECT_LT((next * pivot - Vec(0.03, 0, 1)).norm(), 1e-12);
  EXPECT_TRUE(next.linear().isApprox(rotated(0.25, Vec::Zero()).linear(), 1e-12));
}

TEST(ConstantVelocity, StaysWithoutSteps) {
  const SE3 last = rotated(0.2, Vec(1, 2, 3));
  EXPECT_TRUE(extrapolated(rotated(0.1, Vec::Zero()), last, Vec::Ones(), 0).isApprox(last, 1e-12));
}

} // namespace
} // namespace kinora::tracking
