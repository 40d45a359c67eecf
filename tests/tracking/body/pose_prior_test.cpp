#include "tracking/body/pose_prior.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace kinora::tracking {
namespace {

LimbAngles random_angles(Random& random) {
  LimbAngles angles;
  for (double& angle : angles) angle = random.normal();
  return angles;
}

class PosePriorOfLimb : public ::testing::TestWithParam<Limb> {};

TEST_P(PosePriorOfLimb, HasTheGradientOfItsEnergy) {
  constexpr double kStep = 1e-6;
  Random random(1);
  for (const double trust : {0.0, 0.5, 1.0}) {
    const PosePriorConfig config{0.7, trust};
    for (int i = 0; i < 20; ++i) {
      const LimbAngles angles = random_angles(random);
      const PosePrior prior = pose_prior(GetParam(), angles, config);
      for (int a = 0; a < kLimbAngles; ++a) {
        const LimbAngles step = kStep * LimbAngles::Unit(a);
        const double numeric = (pose_prior(GetParam(), angles + step, config).energy -
                                pose_prior(GetParam(), angles - step, config).energy) /
                               (2 * kStep);
        EXPECT_NEAR(numeric, 2 * prior.gradient[a], 1e-5 * (1 + std::abs(numeric)));
      }
    }
  }
}

// What makes Newton's step safe: the parabola that gradient and Hessian describe lies above the energy.
TEST_P(PosePriorOfLimb, LiesBelowItsParabola) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const LimbAngles from = random_angles(random);
    const LimbAngles to = random_angles(random);
    const PosePrior prior = pose_prior(GetParam(), from, {});
    const LimbAngles step = to - from;
    const double parabola = prior.energy + 2 * prior.gradient.dot(step) + step.dot(prior.hessian * step);
    EXPECT_LE(pose_prior(GetParam(), to, {}).energy, parabola + 1e-9);
    EXPECT_GE(prior.energy, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Limbs, PosePriorOfLimb, ::testing::ValuesIn(kEveryLimb));

TEST(PosePrior, HoldsBothSidesAlike) {
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    const LimbAngles left = random_angles(random);
    const LimbAngles right = LimbAngles(1, -1, -1, 1).cwiseProduct(left);
    EXPECT_NEAR(pose_prior(kLeftArm, left, {}).energy, pose_prior(kRightArm, right, {}).energy, 1e-12);
    EXPECT_NEAR(pose_prior(kLeftLeg, left, {}).energy, pose_prior(kRightLeg, right, {}).energy, 1e-12);
  }
}

TEST(PosePrior, WouldRatherHaveAnArmHangThanStretchedBackwards) {
  const LimbAngles hanging(0, 0, -1.4, 0.5);
  const LimbAngles backwards(0, 1.5, 0, 0);
  EXPECT_LT(pose_prior(kLeftArm, hanging, {}).energy + 1, pose_prior(kLeftArm, backwards, {}).energy);
}

// However unusual a pose, the motions that the table was fitted to add no more than their share's logarithm.
TEST(PosePrior, CostsAnUnusualPoseLittleMoreThanWithoutTheTable) {
  const LimbAngles unusual(2, 2, 1.5, 2.5);
  const double without = pose_prior(kLeftArm, unusual, {1, 0}).energy;
  EXPECT_LT(pose_prior(kLeftArm, unusual, {1, 0.5}).energy, without + 12);
  EXPECT_GT(pose_prior(kLeftArm, unusual, {1, 1}).energy, without + 12);
}

TEST(PosePrior, IsFiniteFarAway) {
  for (const double trust : {0.0, 0.5, 1.0}) {
    const PosePrior prior = pose_prior(kRightLeg, LimbAngles::Constant(1e3), {1, trust});
    EXPECT_TRUE(std::isfinite(prior.energy) && prior.gradient.allFinite() && prior.hessian.allFinite());
  }
}

} // namespace
} // namespace kinora::tracking
