// Vectors among the features turn with the layer: what is drawn of one that is turned.
#include <gtest/gtest.h>

#include "core/random.h"
#include "fields/network/vector_features.h"
#include "fields/rendering/renderer.h"
#include "fields/scenes/arrow_ball.h"
#include "fields/scenes/random_field.h"

namespace kinora::fields {
namespace {

Eigen::Quaterniond quaternion(const Rotation& rotation) {
  return Eigen::Quaternionf(rotation[3], rotation[0], rotation[1], rotation[2]).cast<double>().normalized();
}

TEST(Rotation, TurnsVectorsAndLeavesOtherFeaturesAlone) {
  Random random(1);
  for (int k = 0; k < 100; ++k) {
    const Rotation rotation = testing::random_rotation(random);
    std::array<double, 3 * FieldConfig::kVectors + 1> features{};
    for (double& f : features) f = random.uniform_double() - 0.5;
    auto rotated = features;
    rotate_vectors(rotation, rotated.data());
    EXPECT_EQ(rotated.back(), features.back());
    const Eigen::Vector3d expected = quaternion(rotation) * Eigen::Vector3d(features.data());
    EXPECT_LT((Eigen::Vector3d(rotated.data()) - expected).norm(), 1e-6);
    rotate_vectors(inverse_rotation(rotation), rotated.data());
    for (std::size_t i = 0; i < features.size(); ++i) EXPECT_NEAR(rotated[i], features[i], 1e-6);
  }
}

TEST(Rotation, IsPackedToAThousandthOfADegreeOrTwo) {
  Random random(2);
  for (int k = 0; k < 1000; ++k) {
    const Rotation rotation = testing::random_rotation(random);
    EXPECT_LT(quaternion(rotation).angularDistance(quaternion(unpacked(packed(rotation)))), 1e-4);
  }
}

TEST(Rotation, OfAMatrixIsItsQuaternion) {
  Random random(3);
  for (int k = 0; k < 100; ++k) {
    const Eigen::Quaterniond q = quaternion(testing::random_rotation(random));
    EXPECT_LT(q.angularDistance(quaternion(rotation_of(q.toRotationMatrix()))), 1e-3);
  }
}

void expect_color(const Picture& picture, const Eigen::Array3d& expected) {
  for (const auto& [u, v] : {std::pair(32, 32), std::pair(24, 36), std::pair(40, 28)}) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(picture.color.at(u, v, c), expected[c], 3) << u << " " << v << " " << c;
  }
}

TEST(Rotation, OfARigidLayerTurnsItsVectors) {
  const testing::ArrowBall arrows;
  const DrawableField field(arrows.field());
  Random random(4);
  for (int k = 0; k < 8; ++k) {
    const Eigen::Matrix3d rotation = quaternion(testing::random_rotation(random)).toRotationMatrix();
    const PosedField posed = pose(field, motion::Warp(arrows.pose(rotation)));
    expect_color(render({&posed, 1}, arrows.camera()), 255 * arrows.expected(rotation));
  }
}

TEST(Rotation, OfADeformingLayerTurnsItsVectorsWhereTheyAre) {
  const testing::ArrowBall arrows;
  std::vector<Eigen::Vector3d> nodes;
  for (const double x : {-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3}) {
    for (const double y : {-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3}) {
      for (const double z : {-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3}) {
        nodes.emplace_back(arrows.ball.centre + Eigen::Vector3d(x, y, z));
      }
    }
  }
  const auto graph = std::make_shared<const motion::DeformationGraph>(nodes, 0.12, 0.25);
  const DrawableField field(arrows.field(), graph.get());
  Random random(5);
  for (int k = 0; k < 4; ++k) {
    const Eigen::Matrix3d rotation = quaternion(testing::random_rotation(random)).toRotationMatrix();
    const std::vector<DualQuaternion> rotated(nodes.size(), DualQuaternion::from(arrows.pose(rotation)));
    const PosedField posed = pose(field, motion::Warp(graph, rotated));
    expect_color(render({&posed, 1}, arrows.camera()), 255 * arrows.expected(rotation));
  }
}

} // namespace
} // namespace kinora::fields
