#include "core/dual_quaternion.h"

#include <numbers>

#include <gtest/gtest.h>

#include "core/random.h"

namespace kinora {
namespace {

SE3 random_transform(Random& random, double largest_angle = std::numbers::pi) {
  const Eigen::Vector3d axis(random.normal(), random.normal(), random.normal());
  SE3 transform = SE3::Identity();
  transform.linear() = Eigen::AngleAxisd(largest_angle * random.uniform_double(), axis.normalized()).toRotationMatrix();
  transform.translation() = Eigen::Vector3d(random.normal(), random.normal(), random.normal());
  return transform;
}

DualQuaternion negated(const DualQuaternion& q) {
  DualQuaternion result = q;
  result.real.coeffs() = -q.real.coeffs();
  result.dual.coeffs() = -q.dual.coeffs();
  return result;
}

double largest_difference(const SE3& a, const SE3& b) { return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff(); }

TEST(DualQuaternion, RoundTripKeepsTheTransform) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const SE3 transform = random_transform(random);
    EXPECT_LT(largest_difference(DualQuaternion::from(transform).to_se3(), transform), 1e-12);
  }
}

TEST(DualQuaternion, NegatedIsTheSameTransform) {
  Random random(2);
  const DualQuaternion q = DualQuaternion::from(random_transform(random));
  EXPECT_LT(largest_difference(negated(q).to_se3(), q.to_se3()), 1e-15);
}

TEST(DualQuaternionBlend, IgnoresTheSignOfEachQuaternion) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    std::array<DualQuaternion, 4> transforms;
    std::array<double, 4> weights;
    for (std::size_t k = 0; k < 4; ++k) {
      transforms[k] = DualQuaternion::from(random_transform(random, 1.0));
      weights[k] = 0.1 + random.uniform_double();
    }
    const SE3 expected = blend(transforms, weights).to_se3();
    for (unsigned signs = 1; signs < 16; ++signs) {
      std::array<DualQuaternion, 4> mixed = transforms;
      for (std::size_t k = 0; k < 4; ++k) {
        if ((signs >> k) & 1U) mixed[k] = negated(mixed[k]);
      }
      EXPECT_LT(largest_difference(blend(mixed, weights).to_se3(), expected), 1e-12) << "signs " << signs;
    }
  }
}

TEST(DualQuaternionBlend, OfOneTransformIsThatTransform) {
  Random random(4);
  const SE3 transform = random_transform(random);
  const std::array<DualQuaternion, 3> same = {DualQuaternion::from(transform), negated(DualQuaternion::from(transform)),
                                              DualQuaternion::from(transform)};
  const std::array<double, 3> weights = {0.2, 0.5, 0.1};
  EXPECT_LT(largest_difference(blend(same, weights).to_se3(), transform), 1e-12);
}

TEST(DualQuaternionBlend, HalfwayIsTheScrewMidpoint) {
  Random random(5);
  const SE3 a = random_transform(random, 1.0);
  const SE3 b = random_transform(random, 1.0);
  const std::array<DualQuaternion, 2> ends = {DualQuaternion::from(a), DualQuaternion::from(b)};
  const std::array<double, 2> weights = {0.5, 0.5};
  EXPECT_LT(largest_difference(blend(ends, weights).to_se3(), interpolate(a, b, 0.5)), 1e-9);
}

TEST(DualQuaternionBlend, IsARigidTransformForAnyWeights) {
  Random random(6);
  for (int i = 0; i < 200; ++i) {
    std::array<DualQuaternion, 3> transforms;
    std::array<double, 3> weights;
    for (std::size_t k = 0; k < 3; ++k) {
      transforms[k] = DualQuaternion::from(random_transform(random));
      weights[k] = std::pow(10.0, -6.0 * random.uniform_double());
    }
    const DualQuaternion blended = blend(transforms, weights);
    EXPECT_NEAR(blended.real.norm(), 1.0, 1e-12);
    EXPECT_NEAR(blended.real.coeffs().dot(blended.dual.coeffs()), 0.0, 1e-12);
  }
}

TEST(DualQuaternionBlend, FallsBackToTheFirstTransformWhenAllWeightsVanish) {
  Random random(7);
  const SE3 a = random_transform(random);
  const std::array<DualQuaternion, 2> transforms = {DualQuaternion::from(a),
                                                    DualQuaternion::from(random_transform(random))};
  const std::array<double, 2> weights = {0.0, 0.0};
  EXPECT_LT(largest_difference(blend(transforms, weights).to_se3(), a), 1e-12);
}

TEST(DualQuaternionBlend, StaysFiniteBetweenOppositeRotations) {
  // Half a turn about x one way and the other: their quaternions cancel as far as they ever can.
  const auto rotate_about_x = [](double angle) {
    SE3 transform = SE3::Identity();
    transform.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()).toRotationMatrix();
    return DualQuaternion::from(transform);
  };
  const std::array<DualQuaternion, 3> transforms = {rotate_about_x(0.0), rotate_about_x(2 * std::numbers::pi / 3),
                                                    rotate_about_x(-2 * std::numbers::pi / 3)};
  for (const double third : {0.999999, 1.0, 1.000001}) {
    const std::array<double, 3> weights = {1.0, 1.0, third};
    const SE3 blended = blend(transforms, weights).to_se3();
    EXPECT_TRUE(blended.matrix().allFinite());
    EXPECT_NEAR(blended.linear().determinant(), 1.0, 1e-9);
  }
}

TEST(DualQuaternionBlend, OppositeNeighboursCancelAndLeaveTheHeaviest) {
  DualQuaternion heaviest;
  heaviest.real = Eigen::Quaterniond(0, 0, 0, 1);
  DualQuaternion neighbour;
  neighbour.real = Eigen::Quaterniond(0, 1, 0, 0);
  const std::array<DualQuaternion, 3> transforms = {neighbour, negated(neighbour), heaviest};
  const std::array<double, 3> weights = {1.0, 1.0, 1.0 + 1e-12};
  EXPECT_LT(largest_difference(blend(transforms, weights).to_se3(), heaviest.to_se3()), 1e-9);
}

} // namespace
} // namespace kinora
