// Meshes of fields whose shape and colour are known.
#include <gtest/gtest.h>

#include <map>

#include "bake/analytic_field.h"
#include "bake/mesh_extraction.h"
#include "core/error.h"
#include "core/parallel.h"
#include "fields/scenes/arrow_ball.h"

namespace kinora::bake {
namespace {

using testing::ball_field;
using testing::kRadius;

/// The surface where analytic fields have it: half opaque.
MeshExtractionOptions as_given() {
  MeshExtractionOptions options;
  options.opacity = 0.5;
  return options;
}

host::Mesh mesh_of(const fields::Field& field, const MeshExtractionOptions& options = as_given()) {
  return extract_mesh({"ball", 0, field, motion::Motion::still()}, options, Progress()).value_or(host::Mesh{});
}

TEST(MeshExtraction, OfABallIsClosedAndTurnedOutwards) {
  const host::Mesh mesh = mesh_of(ball_field());
  ASSERT_GT(mesh.faces.size(), 1000U);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  double volume = 0;
  for (const auto& face : mesh.faces) {
    for (std::size_t k = 0; k < 3; ++k) ++edges[{face[k], face[(k + 1) % 3]}];
    volume += mesh.positions[face[0]].cross(mesh.positions[face[1]]).dot(mesh.positions[face[2]]) / 6;
  }
  for (const auto& [edge, count] : edges) {
    ASSERT_EQ(count, 1);
    ASSERT_TRUE(edges.contains({edge.second, edge.first}));
  }
  EXPECT_NEAR(volume, 4.0 / 3 * M_PI * std::pow(kRadius, 3), 0.05 * volume);
}

TEST(MeshExtraction, OfABallHasItsRadiusAndItsNormals) {
  const host::Mesh mesh = mesh_of(ball_field());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    ASSERT_NEAR(mesh.positions[v].norm(), kRadius, 0.5 / 48);
    ASSERT_GT(mesh.normals[v].dot(mesh.positions[v].normalized()), 0.9);
  }
}

TEST(MeshExtraction, ColorsAreThoseOfTheField) {
  const host::Mesh mesh = mesh_of(ball_field());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (std::abs(mesh.positions[v].x()) < 0.1) continue;
    const bool left = mesh.positions[v].x() < 0;
    ASSERT_NEAR(mesh.colors[v][0], 255 * (left ? 0.8 : 0.2), 4);
    ASSERT_NEAR(mesh.colors[v][2], 255 * (left ? 0.3 : 0.8), 4);
  }
}

TEST(MeshExtraction, ColorsAreThoseOfTheMeanFrame) {
  const fields::testing::ArrowBall arrows;
  std::vector<motion::Motion::Pose> poses;
  Eigen::Array3d expected = Eigen::Array3d::Zero();
  for (int i = 0; i < 4; ++i) {
    poses.push_back({arrows.pose(Eigen::AngleAxisd(1.0 * i, Eigen::Vector3d::UnitZ()).toRotationMatrix())});
    expected += 0.25 * arrows.expected(poses.back().canonical_to_world.linear());
  }
  const clip::Layer layer{"ball", 1, arrows.field(), motion::Motion::rigid(poses)};
  const host::Mesh mesh = *extract_mesh(layer, {}, Progress());
  for (const auto& color : mesh.colors) {
    for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(color[c], 255 * expected[static_cast<Eigen::Index>(c)], 3);
  }
}

/// Pictures of soft fields show more than the cells that are half opaque: rays that graze pass several.
TEST(MeshExtraction, ReachesToWhereGrazingRaysAreHalfOpaque) {
  const double cell = testing::unit_config().cell_size();
  const auto opacity_beside = [&](double distance) { // of a ray that passes the ball's middle at this distance
    double thickness = 0;
    for (double s = -0.5; s < 0.5; s += 0.1 * cell) {
      const double outside = std::hypot(distance, s) - kRadius;
      thickness += 0.1 * std::log(2.0) * std::exp(-2 * outside / cell);
    }
    return 1 - std::exp(-thickness);
  };
  double reach = 0;
  const host::Mesh mesh = mesh_of(ball_field(), {});
  for (const Eigen::Vector3f& p : mesh.positions) reach += p.norm() / static_cast<double>(mesh.positions.size());
  EXPECT_GT(opacity_beside(reach), 0.5);
  EXPECT_LT(opacity_beside(reach + cell), 0.5);
  EXPECT_GT(opacity_beside(kRadius), 0.9); // where a cell is half opaque
}

TEST(MeshExtraction, StrayPartsAreLeftOut) {
  const auto distance = [](const Eigen::Vector3d& p) {
    return std::min(p.norm() - 0.3, (p - Eigen::Vector3d::Constant(0.4)).norm() - 0.04);
  };
  const fields::Field field =
      testing::field_of(distance, [](const Eigen::Vector3d&) { return Eigen::Vector3d(0.5, 0.5, 0.5); });
  const auto farthest = [](const host::Mesh& mesh) {
    float max_norm = 0;
    for (const auto& p : mesh.positions) max_norm = std::max(max_norm, p.norm());
    return max_norm;
  };
  MeshExtractionOptions everything = as_given();
  everything.min_component_share = 0;
  EXPECT_GT(farthest(mesh_of(field, everything)), 0.6F);
  EXPECT_LT(farthest(mesh_of(field)), 0.35F);
}

TEST(MeshExtraction, HasAboutAsManyTrianglesAsAskedFor) {
  for (const std::size_t wanted : {1000U, 4000U}) {
    MeshExtractionOptions options;
    options.triangles = wanted;
    const std::size_t made = mesh_of(ball_field(), options).faces.size();
    EXPECT_GT(made, wanted / 2);
    EXPECT_LT(made, wanted * 5 / 4);
  }
}

TEST(MeshExtraction, IsTheSameForAnyNumberOfThreads) {
  set_thread_count(1);
  const host::Mesh one = mesh_of(ball_field());
  set_thread_count(3);
  const host::Mesh three = mesh_of(ball_field());
  set_thread_count(0);
  EXPECT_EQ(one.positions, three.positions);
  EXPECT_EQ(one.faces, three.faces);
  EXPECT_EQ(one.colors, three.colors);
}

TEST(MeshExtraction, OfAnEmptyFieldIsNone) {
  const fields::Field empty(testing::unit_config());
  EXPECT_FALSE(extract_mesh({"nothing", 0, empty, motion::Motion::still()}, {}, Progress()));
}

TEST(MeshExtraction, OptionsThatMakeNoSenseAreRefused) {
  MeshExtractionOptions options;
  options.opacity = 1;
  EXPECT_THROW(mesh_of(ball_field(), options), Error);
  options = {};
  options.triangles = 0;
  EXPECT_THROW(mesh_of(ball_field(), options), Error);
}

} // namespace
} // namespace kinora::bake
