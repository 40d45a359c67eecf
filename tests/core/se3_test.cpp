#include "core/se3.h"

#include <numbers>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/random.h"

namespace kinora {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

Eigen::Vector3d random_vector(Random& random) { return {random.normal(), random.normal(), random.normal()}; }

SE3 random_transform(Random& random, double angle, double metres) {
  SE3 transform = SE3::Identity();
  transform.linear() = Eigen::AngleAxisd(angle, random_vector(random).normalized()).toRotationMatrix();
  transform.translation() = metres * random_vector(random).normalized();
  return transform;
}

double largest_difference(const SE3& a, const SE3& b) { return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff(); }

TEST(Se3, ExponentialUndoesLogarithmAtEveryAngle) {
  Random random(1);
  for (const double degrees : {0.0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3, 0.1, 1.0, 45.0, 90.0, 179.0, 179.9, 179.999999}) {
    for (int i = 0; i < 50; ++i) {
      const SE3 transform = random_transform(random, degrees * kDegree, 2.0);
      EXPECT_LT(largest_difference(exp_se3(log_se3(transform)), transform), 1e-9) << degrees << " degrees";
    }
  }
}

TEST(Se3, ExponentialUndoesLogarithmAtHalfATurnExactly) {
  for (int axis = 0; axis < 3; ++axis) {
    SE3 transform = SE3::Identity();
    transform.linear() = -Eigen::Matrix3d::Identity();
    transform.linear()(axis, axis) = 1;
    transform.translation() = Eigen::Vector3d(0.3, -0.2, 0.1);
    EXPECT_LT(largest_difference(exp_se3(log_se3(transform)), transform), 1e-9) << "axis " << axis;
    EXPECT_NEAR(rotation_angle(transform), std::numbers::pi, 1e-12);
  }
}

TEST(Se3, RoundTripKeepsMicrometresAtOneKilometre) {
  Random random(2);
  for (const double degrees : {1e-6, 0.01, 3.0, 120.0, 179.9}) {
    for (int i = 0; i < 20; ++i) {
      const SE3 transform = random_transform(random, degrees * kDegree, 1000.0);
      EXPECT_LT(largest_difference(exp_se3(log_se3(transform)), transform), 1e-6) << degrees << " degrees";
    }
  }
}

TEST(Se3, LogarithmUndoesExponentialBelowHalfATurn) {
  Random random(3);
  for (const double degrees : {1e-8, 1e-4, 0.5, 60.0, 179.9}) {
    for (int i = 0; i < 50; ++i) {
      Twist twist;
      twist << random_vector(random), degrees * kDegree * random_vector(random).normalized();
      EXPECT_LT((log_se3(exp_se3(twist)) - twist).cwiseAbs().maxCoeff(), 1e-9) << degrees << " degrees";
    }
  }
}

TEST(Se3, ExponentialOfManyTurnsIsStillARotation) {
  Random random(4);
  for (int i = 0; i < 50; ++i) {
    Twist twist;
    twist << random_vector(random), 1e3 * random_vector(random);
    const SE3 transform = exp_se3(twist);
    EXPECT_TRUE(transform.matrix().allFinite());
    EXPECT_LT((transform.linear() * transform.linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_NEAR(transform.linear().determinant(), 1.0, 1e-12);
  }
}

TEST(Se3, ExponentialIsTheLimitOfManySmallSteps) {
  Twist twist;
  twist << 0.4, -0.2, 0.7, 0.9, 0.1, -0.5;
  SE3 steps = SE3::Identity();
  constexpr int kSteps = 1 << 16;
  for (int i = 0; i < kSteps; ++i) {
    SE3 step = SE3::Identity();
    step.linear() += skew(twist.tail<3>() / kSteps);
    step.translation() = twist.head<3>() / kSteps;
    steps = steps * step;
  }
  EXPECT_LT(largest_difference(steps, exp_se3(twist)), 1e-4);
}

TEST(Se3, SkewIsTheCrossProduct) {
  Random random(5);
  const Eigen::Vector3d a = random_vector(random);
  const Eigen::Vector3d b = random_vector(random);
  EXPECT_LT((skew(a) * b - a.cross(b)).norm(), 1e-15);
}

TEST(Se3, InterpolationMeetsBothEndsAndMovesEvenly) {
  Random random(6);
  const SE3 a = random_transform(random, 1.0, 1.0);
  const SE3 b = random_transform(random, 2.0, 3.0);
  EXPECT_LT(largest_difference(interpolate(a, b, 0.0), a), 1e-12);
  EXPECT_LT(largest_difference(interpolate(a, b, 1.0), b), 1e-9);
  const SE3 first_half = a.inverse() * interpolate(a, b, 0.5);
  const SE3 second_half = interpolate(a, b, 0.5).inverse() * b;
  EXPECT_LT(largest_difference(first_half, second_half), 1e-9);
}

ErrorCode code_of_rigid(const Eigen::Matrix4d& matrix, std::string* sentence = nullptr) {
  try {
    rigid_from_matrix(matrix, "pose.txt");
  } catch (const Error& error) {
    if (sentence != nullptr) *sentence = error.what();
    return error.code();
  }
  return ErrorCode::kFailure;
}

TEST(RigidFromMatrix, RepairsRoundingOfPrintedPoses) {
  Random random(7);
  const SE3 transform = random_transform(random, 0.7, 2.0);
  Eigen::Matrix4d printed = transform.matrix();
  printed.topLeftCorner<3, 3>() += 1e-4 * Eigen::Matrix3d::Ones();
  const SE3 repaired = rigid_from_matrix(printed, "pose.txt");
  EXPECT_LT((repaired.linear() * repaired.linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LT(largest_difference(repaired, transform), 1e-3);
}

TEST(RigidFromMatrix, RejectsWhatIsNoRigidTransform) {
  Eigen::Matrix4d scaled = Eigen::Matrix4d::Identity();
  scaled.topLeftCorner<3, 3>() *= 1000;
  Eigen::Matrix4d mirrored = Eigen::Matrix4d::Identity();
  mirrored(0, 0) = -1;
  Eigen::Matrix4d projective = Eigen::Matrix4d::Identity();
  projective(3, 0) = 0.5;
  Eigen::Matrix4d not_a_number = Eigen::Matrix4d::Identity();
  not_a_number(0, 3) = std::numeric_limits<double>::quiet_NaN();
  Eigen::Matrix4d infinite = Eigen::Matrix4d::Identity();
  infinite(2, 3) = std::numeric_limits<double>::infinity();
  const Eigen::Matrix4d zero = Eigen::Matrix4d::Zero();
  for (const Eigen::Matrix4d& matrix : {scaled, mirrored, projective, not_a_number, infinite, zero}) {
    std::string sentence;
    EXPECT_EQ(code_of_rigid(matrix, &sentence), ErrorCode::kCorruptInput) << matrix;
    EXPECT_NE(sentence.find("pose.txt"), std::string::npos) << sentence;
  }
}

} // namespace
} // namespace kinora
