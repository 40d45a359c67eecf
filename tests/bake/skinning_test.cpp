// Meshes that follow a motion through joints and weights.
#include <gtest/gtest.h>

#include <numeric>

#include "bake/analytic_field.h"
#include "bake/mesh_extraction.h"
#include "bake/skinning.h"

namespace kinora::bake {
namespace {

constexpr int kFrames = 4;

host::Mesh mesh_with(const motion::Motion& motion) {
  MeshExtractionOptions options;
  options.triangles = 3000;
  return extract_mesh({"ball", 1, testing::ball_field(), motion}, options, Progress()).value();
}

/// Where a skinned mesh puts a vertex.
Eigen::Vector3d placed(const host::Mesh& mesh, const std::vector<SE3>& joints, std::size_t v) {
  const Eigen::Vector3d p = mesh.positions[v].cast<double>();
  if (mesh.skin.joints.empty()) return joints[0] * (mesh.skin.inverse_bind[0] * p);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t j = mesh.skin.joints[v][k];
    sum += mesh.skin.weights[v][k] * (joints[j] * (mesh.skin.inverse_bind[j] * p));
  }
  return sum;
}

TEST(Skinning, OfAStillLayerIsNone) {
  host::Mesh mesh = mesh_with(motion::Motion::still());
  const Skinning skinning(motion::Motion::still(), mesh);
  EXPECT_FALSE(skinning.moves());
  EXPECT_TRUE(mesh.skin.inverse_bind.empty());
  EXPECT_TRUE(skinning.joints_at(0).empty());
}

TEST(Skinning, OfARigidLayerIsOneJointThatCarriesEveryVertexExactly) {
  const motion::Motion motion = testing::rigid_motion(kFrames);
  host::Mesh mesh = mesh_with(motion);
  const Skinning skinning(motion, mesh);
  ASSERT_EQ(mesh.skin.inverse_bind.size(), 1U);
  for (int frame = 0; frame < kFrames; ++frame) {
    for (std::size_t v = 0; v < mesh.positions.size(); v += 7) {
      const Eigen::Vector3d expected = motion.canonical_to_world(frame) * mesh.positions[v].cast<double>();
      ASSERT_LT((placed(mesh, skinning.joints_at(frame), v) - expected).norm(), 1e-9);
    }
  }
}

TEST(Skinning, WeightsOfADeformingLayerAddUpToOneOverDifferentJoints) {
  const motion::Motion motion = testing::bending_motion(kFrames);
  host::Mesh mesh = mesh_with(motion);
  const Skinning skinning(motion, mesh);
  ASSERT_EQ(mesh.skin.joints.size(), mesh.positions.size());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const auto& weights = mesh.skin.weights[v];
    ASSERT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0F), 1, 1e-5);
    for (std::size_t a = 0; a < 4; ++a) {
      ASSERT_LT(mesh.skin.joints[v][a], mesh.skin.inverse_bind.size());
      for (std::size_t b = 0; b < a; ++b) {
        ASSERT_TRUE(weights[a] == 0 || weights[b] == 0 || mesh.skin.joints[v][a] != mesh.skin.joints[v][b]);
      }
    }
  }
}

TEST(Skinning, OfADeformingLayerFollowsItsWarpUpToTheKnownDifference) {
  const motion::Motion motion = testing::bending_motion(kFrames);
  host::Mesh mesh = mesh_with(motion);
  const Skinning skinning(motion, mesh);
  const std::vector<int> frames = {0, 1, 2, 3};
  const Skinning::Difference difference = skinning.blending_difference(mesh, frames);
  EXPECT_GT(difference.largest, 0);
  EXPECT_LT(difference.largest, 0.003);
  EXPECT_LE(difference.mean, difference.largest);
  for (const int frame : frames) {
    const motion::Warp warp = motion.warp(frame);
    const std::vector<SE3> joints = skinning.joints_at(frame);
    for (std::size_t v = 0; v < mesh.positions.size(); v += 7) {
      const Eigen::Vector3d exact = warp.to_world(mesh.positions[v].cast<double>()).value();
      ASSERT_LT((placed(mesh, joints, v) - exact).norm(), 0.003);
    }
  }
}

TEST(Skinning, HasNoDifferenceWhereAllNodesMoveAlike) {
  const motion::Motion motion = testing::bending_motion(kFrames, 0);
  host::Mesh mesh = mesh_with(motion);
  const Skinning skinning(motion, mesh);
  const std::vector<int> frames = {0, 3};
  EXPECT_LT(skinning.blending_difference(mesh, frames).largest, 1e-6);
}

TEST(Skinning, JointsStandAtTheNodesOfTheGraph) {
  const motion::Motion motion = testing::bending_motion(kFrames);
  host::Mesh mesh = mesh_with(motion);
  const Skinning skinning(motion, mesh);
  const motion::Warp warp = motion.warp(2);
  const std::vector<Eigen::Vector3d>& nodes = warp.node_positions();
  for (const SE3& joint : skinning.joints_at(2)) {
    double nearest = 1;
    for (const Eigen::Vector3d& node : nodes) nearest = std::min(nearest, (node - joint.translation()).norm());
    ASSERT_LT(nearest, 1e-9);
  }
}

} // namespace
} // namespace kinora::bake
