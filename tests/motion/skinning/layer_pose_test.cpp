#include "motion/skinning/layer_pose.h"

#include <cmath>
#include <numbers>

#include "node_motions.h"
#include "support/every_instruction_set.h"

namespace kinora::motion {
namespace {

using testing::random_vector;

class LayerPoseTest : public OnEveryInstructionSet {};

TEST_P(LayerPoseTest, HasPointsWhereBlendingHasThem) {
  Random random(2);
  NodeStates states;
  for (int n = 0; n < 40; ++n) {
    Twist twist;
    twist << random_vector(random, 0.5), random_vector(random, 1);
    const DualQuaternion transform = DualQuaternion::from(exp_se3(twist));
    states.push_back(n % 3 == 0 ? testing::negated(transform) : transform, random_vector(random, 0.3));
  }
  std::vector<SkinnedPoint> points;
  for (int p = 0; p < 103; ++p) {
    Influence influence;
    influence.count = 1 + p % Influence::kMax;
    double left = 1;
    for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
      influence.nodes[k] = static_cast<int>(random.below(40));
      influence.weights[k] = static_cast<int>(k) + 1 == influence.count ? left : 0.6 * left;
      left -= influence.weights[k];
    }
    points.emplace_back(random_vector(random, 0.5).cast<float>(), random_vector(random, 1).normalized().cast<float>(),
                        influence);
  }
  const LayerPose pose = pose_layer(points, states);
  for (std::size_t p = 0; p < points.size(); ++p) {
    const BlendedMotion blended = blend_motion(states, points[p].influence());
    const Eigen::Vector3d position = blended.apply(points[p].position.cast<double>());
    // Where rotations nearly cancel, rounding counts for more.
    const double tolerance = 1e-6 / std::min(1.0, blended.real_norm * blended.real_norm);
    EXPECT_LT((pose.points[p].position.cast<double>() - position).norm(), 5 * tolerance) << p;
    EXPECT_LT((pose.points[p].normal.cast<double>() - blended.rotate(points[p].normal.cast<double>())).norm(),
              tolerance)
        << p;
  }
}

TEST_P(LayerPoseTest, IsFiniteWhereRotationsCancel) {
  const testing::CancellingRotations rotations;
  const std::vector<SkinnedPoint> points(1, SkinnedPoint({1, 2, 3}, {0, 0, 1}, rotations.influence));
  EXPECT_TRUE(pose_layer(points, rotations.states).points[0].position.allFinite());
}

TEST_P(LayerPoseTest, StaysAtItsDistanceWhereNeighboursTurnApartBy179Point9Degrees) {
  Random random(3);
  NodeStates states;
  const Eigen::Vector3d axis = random_vector(random, 1).normalized();
  for (int n = 0; n < 8; ++n) {
    const double angle = n % 2 == 0 ? 0 : 179.9 / 180 * std::numbers::pi;
    states.push_back(DualQuaternion::from(SE3(Eigen::AngleAxisd(angle, axis))), random_vector(random, 0.3));
  }
  for (int round = 0; round < 100; ++round) {
    Influence influence;
    influence.count = 4;
    influence.weights = {0.4, 0.3, 0.2, 0.1};
    for (int& node : influence.nodes) node = static_cast<int>(random.below(8));
    const Eigen::Vector3d at = random_vector(random, 0.5);
    const std::vector<SkinnedPoint> points(1, SkinnedPoint(at.cast<float>(), {0, 0, 1}, influence));
    const Eigen::Vector3d position = pose_layer(points, states).points[0].position.cast<double>();
    EXPECT_NEAR(position.norm(), at.norm(), 1e-5);
    EXPECT_LT((position - blend_motion(states, influence).apply(at)).norm(), 1e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, LayerPoseTest, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::motion
