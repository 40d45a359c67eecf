#include "motion/skinning/blended_motion.h"

#include <gtest/gtest.h>

#include "node_motions.h"

namespace kinora::motion {
namespace {

using testing::negated;
using testing::random_vector;

/// Four nodes that have moved far and apart, and a point between them.
struct Scene {
  std::vector<Eigen::Vector3d> nodes;
  NodeStates states;
  Influence influence;
  Eigen::Vector3d point;

  explicit Scene(std::uint64_t seed, double angle = 0.5) {
    Random random(seed);
    influence.count = 4;
    influence.weights = {0.4, 0.3, 0.2, 0.1};
    Twist common;
    common << random_vector(random, 0.5), random_vector(random, 1);
    for (int i = 0; i < 4; ++i) {
      influence.nodes[static_cast<std::size_t>(i)] = i;
      nodes.push_back(random_vector(random, 0.05));
      Twist relative;
      relative << random_vector(random, 0.05), random_vector(random, angle);
      states.push_back(DualQuaternion::from(exp_se3(common) * exp_se3(relative)), nodes.back());
    }
    point = random_vector(random, 0.05);
  }
};

TEST(BlendedMotion, CarriesPointsAsTheWarpDoes) {
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    const Scene s(seed);
    const SE3 expected = blend(s.states.transforms, s.influence.weights).to_se3();
    const BlendedMotion blended = blend_motion(s.states, s.influence);
    EXPECT_LT((blended.apply(s.point) - expected * s.point).norm(), 1e-12);
    EXPECT_LT((blended.rotate(s.point) - expected.linear() * s.point).norm(), 1e-12);
  }
}

TEST(BlendedMotion, DerivativesAgreeWithDifferences) {
  for (std::uint64_t seed = 1; seed < 30; ++seed) {
    const Scene s(seed);
    const BlendedMotion blended = blend_motion(s.states, s.influence);
    const Eigen::Vector3d position = blended.apply(s.point);
    const Eigen::Vector3d g(0.3, -0.5, 0.8);
    for (std::size_t slot = 0; slot < 4; ++slot) {
      const Twist derivative = NodeJacobian(s.states, s.influence, blended, slot).pullback(g, position.cross(g));
      for (int i = 0; i < 6; ++i) {
        constexpr double kStep = 1e-6;
        const auto value = [&](double step) {
          std::vector<Twist> steps(4, Twist::Zero());
          steps[slot][i] = step;
          return g.dot(blend_motion(stepped(s.states, steps), s.influence).apply(s.point));
        };
        EXPECT_NEAR(derivative[i], (value(kStep) - value(-kStep)) / (2 * kStep), 1e-7)
            << seed << ' ' << slot << ' ' << i;
      }
    }
  }
}

TEST(BlendedMotion, AQuaternionAndItsNegativeAreTheSameTransform) {
  const Scene s(3);
  NodeStates flipped = s.states;
  for (const std::size_t i : {1U, 3U}) flipped.transforms[i] = negated(flipped.transforms[i]);
  const BlendedMotion a = blend_motion(s.states, s.influence);
  const BlendedMotion b = blend_motion(flipped, s.influence);
  EXPECT_LT((a.apply(s.point) - b.apply(s.point)).norm(), 1e-13);
  const Eigen::Vector3d g(1, 2, 3);
  for (std::size_t slot = 0; slot < 4; ++slot) {
    const NodeJacobian part(s.states, s.influence, a, slot);
    const NodeJacobian same(flipped, s.influence, b, slot);
    EXPECT_LT((part.pullback(g, g) - same.pullback(g, g)).norm(), 1e-12);
  }
}

TEST(BlendedMotion, StaysFiniteWhereRotationsCancel) {
  const testing::CancellingRotations rotations;
  const BlendedMotion blended = blend_motion(rotations.states, rotations.influence);
  EXPECT_TRUE(blended.apply({1, 2, 3}).allFinite());
  for (std::size_t slot = 0; slot < 4; ++slot) {
    EXPECT_TRUE(
        NodeJacobian(rotations.states, rotations.influence, blended, slot).pullback({1, 0, 0}, {0, 1, 0}).allFinite());
  }
}

TEST(NodeStates, MoveAsOneBody) {
  const Scene s(5);
  Twist twist;
  twist << 0.1, -0.2, 0.3, 0.4, 0.5, -0.6;
  const SE3 motion = exp_se3(twist);
  const NodeStates after = moved(s.states, motion);
  const Eigen::Vector3d before = blend_motion(s.states, s.influence).apply(s.point);
  EXPECT_LT((blend_motion(after, s.influence).apply(s.point) - motion * before).norm(), 1e-12);
}

} // namespace
} // namespace kinora::motion
