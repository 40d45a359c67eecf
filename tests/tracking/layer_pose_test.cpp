#include "tracking/layer_pose.h"

#include <cmath>
#include <numbers>

#include "core/random.h"
#include "support/every_instruction_set.h"

namespace kinora::tracking {
namespace {

Eigen::Vector3d random_vector(Random& random, double size) {
  return size * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
}

class LayerPoseTest : public OnEveryInstructionSet {};

TEST_P(LayerPoseTest, HasPointsWhereBlendingHasThem) {
  Random random(2);
  NodeStates states;
  for (int n = 0; n < 40; ++n) {
    Twist twist;
    twist << random_vector(random, 0.5), random_vector(random, 1);
    DualQuaternion transform = DualQuaternion::from(exp_se3(twist));
    if (n % 3 == 0) {
      transform.real.coeffs() *= -1; // the same transform
      transform.dual.coeffs() *= -1;
    }
    states.push_back(transform, random_vector(random, 0.3));
  }
  std::vector<SkinnedPoint> points;
  for (int p = 0; p < 103; ++p) {
    Influence influence;
    influence.count = 1 + p % Influence::kMost;
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
    const Eigen::Vector3d place = blended.apply(points[p].position.cast<double>());
    // Where rotations nearly cancel, rounding counts for more.
    const double tolerance = 1e-6 / std::min(1.0, blended.real_norm * blended.real_norm);
    EXPECT_LT((pose.points[p].place.cast<double>() - place).norm(), 5 * tolerance) << p;
    EXPECT_LT((pose.points[p].normal.cast<double>() - blended.rotate(points[p].normal.cast<double>())).norm(),
              tolerance)
        << p;
  }
}

TEST_P(LayerPoseTest, IsFiniteWhereRotationsCancel) {
  NodeStates states;
  Influence influence;
  influence.count = 4;
  influence.weights = {0.25, 0.25, 0.25, 0.25};
  for (int i = 0; i < 4; ++i) {
    influence.nodes[static_cast<std::size_t>(i)] = i;
    const double angle = 0.5 * std::numbers::pi * i;
    states.push_back(DualQuaternion::from(SE3(
                         Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d(std::cos(angle), std::sin(angle), 0)))),
                     Eigen::Vector3d::Zero());
  }
  const std::vector<SkinnedPoint> points(1, SkinnedPoint({1, 2, 3}, {0, 0, 1}, influence));
  EXPECT_TRUE(pose_layer(points, states).points[0].place.allFinite());
}

INSTANTIATE_TEST_SUITE_P(Sets, LayerPoseTest, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::tracking
