#include "motion/skinning/skinned_lanes.h"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "node_motions.h"
#include "support/every_instruction_set.h"

namespace kinora::motion {
namespace {

using testing::random_vector;

/// Nodes about the volume's origin that have moved apart, three metres before the camera.
struct Scene {
  std::vector<Eigen::Vector3d> nodes;
  NodeStates states;
  std::vector<std::int32_t> all;
  std::vector<PositionRow> positions;

  Scene(Random& random, std::size_t count) : all(count) {
    std::iota(all.begin(), all.end(), 0);
    for (std::size_t i = 0; i < count; ++i) {
      nodes.push_back(random_vector(random, 0.1));
      positions.push_back(position_row(nodes[i]));
      Twist twist;
      twist << random_vector(random, 0.05) + Eigen::Vector3d(0, 0, 3), random_vector(random, 0.3);
      const DualQuaternion transform = DualQuaternion::from(exp_se3(twist));
      states.push_back(i % 3 == 0 ? testing::negated(transform) : transform, nodes[i]);
    }
  }
};

class SkinnedLanesOnEveryInstructionSet : public OnEveryInstructionSet {};

PointLanes random_points(Random& random, double size) {
  PointLanes points{};
  for (std::size_t i = 0; i < PointLanes::kPoints; ++i) points.set(i, random_vector(random, size).cast<float>());
  return points;
}

// By how much each node's share differs, at most.
double difference(const Influence& a, const Influence& b, std::size_t nodes) {
  std::vector<double> shares(nodes, 0);
  for (std::size_t k = 0; k < static_cast<std::size_t>(a.count); ++k) {
    shares[static_cast<std::size_t>(a.nodes[k])] += a.weights[k];
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(b.count); ++k) {
    shares[static_cast<std::size_t>(b.nodes[k])] -= b.weights[k];
  }
  return std::abs(
      *std::max_element(shares.begin(), shares.end(), [](double x, double y) { return std::abs(x) < std::abs(y); }));
}

TEST_P(SkinnedLanesOnEveryInstructionSet, NodesWeighAsInTheGraph) {
  Random random(4);
  int moved = 0;
  for (const std::size_t count : {1U, 3U, 4U, 5U, 30U, 200U}) {
    const Scene scene(random, count);
    const DeformationGraph graph(scene.nodes, 0.04, 0.12);
    for (int round = 0; round < 20; ++round) {
      const PointLanes points = random_points(random, 0.15);
      InfluenceLanes influences;
      skinning_weights({scene.all, scene.positions.data(), 0.12F, 0.04F}, points, influences);
      for (std::size_t i = 0; i < PointLanes::kPoints; ++i) {
        const Influence expected = graph.influence(points.at(i).cast<double>());
        const Influence found = influences.at(i);
        ASSERT_EQ(found.count > 0, expected.count > 0);
        EXPECT_LT(difference(found, expected, count), 1e-4);
        if (found.count > 0) ++moved;
      }
    }
  }
  EXPECT_GT(moved, 300);
}

TEST_P(SkinnedLanesOnEveryInstructionSet, WithoutNodesNothingMovesAPoint) {
  Random random(5);
  InfluenceLanes influences;
  skinning_weights({{}, nullptr, 0.12F, 0.04F}, random_points(random, 0.1), influences);
  for (std::size_t i = 0; i < PointLanes::kPoints; ++i) EXPECT_EQ(influences.at(i).count, 0);
}

TEST_P(SkinnedLanesOnEveryInstructionSet, PointsAreCarriedAsOneByOne) {
  Random random(6);
  const Scene scene(random, 30);
  const std::vector<TransformRow> transforms = transform_rows(scene.states.transforms);
  for (int round = 0; round < 50; ++round) {
    const PointLanes points = random_points(random, 0.2);
    const PointLanes vectors = random_points(random, 1);
    InfluenceLanes influences{};
    std::array<Influence, PointLanes::kPoints> plain;
    for (std::size_t i = 0; i < plain.size(); ++i) {
      plain[i].count = static_cast<int>(random.below(5));
      double left = 1;
      for (std::size_t k = 0; k < static_cast<std::size_t>(plain[i].count); ++k) {
        plain[i].nodes[k] = static_cast<int>(random.below(30));
        left -= plain[i].weights[k] = k + 1 == static_cast<std::size_t>(plain[i].count) ? left : 0.6 * left;
      }
      influences.set(i, plain[i]);
    }
    PointLanes positions, same, rotated;
    skin_points(transforms, influences, points, positions, vectors, rotated);
    skin_points(transforms, influences, points, same);
    for (std::size_t i = 0; i < plain.size(); ++i) {
      if (plain[i].count == 0) {
        EXPECT_TRUE(positions.at(i).hasNaN());
        continue;
      }
      const BlendedMotion motion = blend_motion(scene.states, plain[i]);
      EXPECT_LT((positions.at(i).cast<double>() - motion.apply(points.at(i).cast<double>())).norm(), 5e-6);
      EXPECT_LT((rotated.at(i).cast<double>() - motion.rotate(vectors.at(i).cast<double>())).norm(), 5e-6);
      EXPECT_EQ(positions.at(i), same.at(i));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, SkinnedLanesOnEveryInstructionSet, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::motion
