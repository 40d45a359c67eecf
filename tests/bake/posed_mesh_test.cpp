// Meshes carried along by a warp.
#include <gtest/gtest.h>

#include "bake/analytic_field.h"
#include "bake/mesh_extraction.h"
#include "bake/posed_mesh.h"

namespace kinora::bake {
namespace {

host::Mesh ball() {
  MeshExtractionOptions options;
  options.triangles = 3000;
  return extract_mesh({"ball", 1, testing::ball_field(), motion::Motion::still()}, options, Progress()).value();
}

TEST(PosedMesh, LiesWhereTheWarpPutsEveryVertexAndNormalsStayUnitVectors) {
  const host::Mesh mesh = ball();
  const motion::Motion motions[] = {motion::Motion::still(), testing::rigid_motion(4), testing::bending_motion(4)};
  for (const motion::Motion& motion : motions) {
    const motion::Warp warp = motion.warp(3);
    const host::Mesh posed = posed_mesh(mesh, warp);
    EXPECT_EQ(posed.faces, mesh.faces);
    EXPECT_EQ(posed.colors, mesh.colors);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const auto expected = warp.to_world(mesh.positions[v].cast<double>());
      ASSERT_TRUE(expected);
      ASSERT_LT((posed.positions[v].cast<double>() - *expected).norm(), 1e-6);
      ASSERT_NEAR(posed.normals[v].norm(), 1, 1e-5);
    }
  }
}

TEST(PosedMesh, NormalsTurnWithTheSurface) {
  const host::Mesh mesh = ball();
  const motion::Motion motion = testing::rigid_motion(4);
  const motion::Warp warp = motion.warp(3);
  ASSERT_FALSE(warp.rigid().linear().isIdentity(1e-3));
  const host::Mesh posed = posed_mesh(mesh, warp);
  for (std::size_t v = 0; v < mesh.normals.size(); ++v)
    ASSERT_LT((posed.normals[v].cast<double>() - warp.rigid().linear() * mesh.normals[v].cast<double>()).norm(), 1e-6);
}

} // namespace
} // namespace kinora::bake
