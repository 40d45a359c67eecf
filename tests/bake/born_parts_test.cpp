// Meshes in pieces by when they are there.
#include "bake/born_parts.h"

#include <set>

#include <gtest/gtest.h>

#include "bake/analytic_field.h"
#include "bake/mesh_extraction.h"
#include "bake/nearest_layer.h"
#include "bake/volume.h"

namespace kinora::bake {
namespace {

/// A ball of which what lies beyond the middle is born later the farther it is.
clip::Layer late_ball() {
  clip::Layer layer{"ball", 1, testing::ball_field(), testing::bending_motion(12, 0)};
  std::vector<std::uint32_t> births;
  for (const Eigen::Vector3d& node : layer.motion.graph()->nodes())
    births.push_back(node.x() < 0.1 ? 0 : static_cast<std::uint32_t>(std::lround(20 * node.x())));
  layer.births = motion::NodeBirths(std::move(births));
  return layer;
}

host::Mesh mesh_of(const clip::Layer& layer) {
  MeshExtractionOptions options;
  options.triangles = 3000;
  return extract_mesh(layer, options, Progress()).value();
}

std::uint32_t birth_at(const clip::Layer& layer, const Eigen::Vector3f& vertex) {
  return layer.births.birth_of(layer.motion.graph()->influence(vertex.cast<double>()));
}

TEST(BornParts, HoldEveryTriangleOnceAndNoneBeforeItIsBorn) {
  const clip::Layer layer = late_ball();
  const host::Mesh mesh = mesh_of(layer);
  for (const std::size_t most : {2U, 3U, 100U}) {
    const std::vector<BornPart> parts = born_parts(mesh, layer, most);
    EXPECT_LE(parts.size(), most);
    EXPECT_GT(parts.size(), 1U);
    EXPECT_EQ(parts.front().birth, 0U);
    std::size_t faces = 0;
    std::set<std::string> names;
    for (const BornPart& part : parts) {
      faces += part.mesh.faces.size();
      names.insert(part.mesh.name);
      ASSERT_EQ(part.mesh.colors.size(), part.mesh.positions.size());
      ASSERT_EQ(part.mesh.normals.size(), part.mesh.positions.size());
      for (const Eigen::Vector3f& vertex : part.mesh.positions) ASSERT_LE(birth_at(layer, vertex), part.birth);
    }
    EXPECT_EQ(faces, mesh.faces.size());
    EXPECT_EQ(names.size(), parts.size());
  }
}

TEST(BornParts, OfWhatIsThereFromTheStartAreTheMesh) {
  clip::Layer layer = late_ball();
  layer.births = {};
  const host::Mesh mesh = mesh_of(layer);
  const std::vector<BornPart> parts = born_parts(mesh, layer, 6);
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].birth, 0U);
  EXPECT_EQ(parts[0].mesh.name, "ball");
  EXPECT_EQ(parts[0].mesh.positions, mesh.positions);
}

TEST(BornParts, VolumesHoldNothingOfWhatIsNotBorn) {
  clip::Clip clip = testing::sample_clip(12);
  clip.layers = {late_ball()};
  const std::vector<std::size_t> layers = {0};
  VolumeBaker baker(clip, layers, {0.03, 0.01});
  const auto farthest = [&](int frame) {
    const host::Volume volume = baker.at(frame, Progress());
    double x = -1;
    for (const auto& voxel : volume.voxels) x = std::max(x, 0.03 * voxel[0]);
    return x;
  };
  EXPECT_LT(farthest(0), 0.2);
  EXPECT_GT(farthest(11), 0.25);
}

TEST(BornParts, PointsAreNotFoundOnWhatIsNotBorn) {
  clip::Clip clip = testing::sample_clip(12);
  clip.layers = {{"floor", 0, testing::ball_field({0, 0.2, 0}, 0.1), motion::Motion::still()}, late_ball()};
  const auto nearest = [&](int frame) {
    const std::vector<Eigen::Vector3d> points = {
        clip.layers[1].motion.warp(frame).to_world({testing::kRadius, 0, 0}).value()};
    return nearest_layers(clip, frame, points, Progress())[0];
  };
  EXPECT_EQ(nearest(11), 1U);
  clip.layers.resize(2);
  clip.layers[0].field = testing::ball_field({0.45, 0, 0}, 0.03);
  EXPECT_EQ(nearest(0), 0U) << "the thing beside it is nearer than what is there of the ball";
}

} // namespace
} // namespace kinora::bake
