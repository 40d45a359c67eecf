// Meshes of fields whose shape and colour are known.
#include <gtest/gtest.h>

#include <map>

#include "bake/analytic_field.h"
#include "bake/flat_surface.h"
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

TEST(MeshExtraction, WhatIsStoredHollowIsAsSolidAsItWas) {
  fields::Field field = ball_field();
  const host::Mesh solid = mesh_of(field);
  for (int z = 0; z < 64; ++z) {
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        const Eigen::Vector3d middle = (Eigen::Vector3d(x, y, z).array() + 0.5 - 32).matrix() / 64;
        if (middle.norm() < kRadius - 3.0 / 48) field.occupancy.set(x, y, z, false);
      }
    }
  }
  const host::Mesh hollow = mesh_of(field);
  EXPECT_EQ(hollow.positions, solid.positions);
  EXPECT_EQ(hollow.faces, solid.faces);
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
  everything.still_component_share = 0;
  EXPECT_GT(farthest(mesh_of(field, everything)), 0.6F);
  EXPECT_GT(farthest(mesh_of(field)), 0.6F) << "in a room, things stand by themselves";
  const clip::Layer moving{"ball", 1, field, motion::Motion::rigid({{SE3::Identity()}})};
  EXPECT_LT(farthest(*extract_mesh(moving, as_given(), Progress())), 0.35F);
}

TEST(MeshExtraction, ReachesToWhereWhatIsStoredEnds) {
  fields::Field field = testing::field_of([](const Eigen::Vector3d&) { return -1.0; },
                                          [](const Eigen::Vector3d&) { return Eigen::Vector3d(0.5, 0.5, 0.5); });
  const int r = field.config.occupancy_resolution;
  field.occupancy = fields::Occupancy(r);
  for (int i = 0; i < r * r * r; ++i)
    if (i % r >= r / 4 && i % r < 3 * r / 4) field.occupancy.set(i % r, i / r % r, i / r / r);
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : mesh_of(field).positions) box.extend(p);
  EXPECT_NEAR(box.max().x(), 0.25F, 0.002F);
  EXPECT_NEAR(box.min().x(), -0.25F, 0.002F);
  EXPECT_NEAR(box.max().y(), 0.5F, 0.002F) << "the box's own end";
}

/// A slab in waves of 1 cm, 4 cm thick, with a ball on it or without.
fields::Field floor_field(double ball) {
  return testing::field_of(
      [ball](const Eigen::Vector3d& p) {
        const double slab = std::max(
            {std::abs(p.y() - 0.01 * std::sin(20 * p.x())) - 0.02, std::abs(p.x()) - 0.42, std::abs(p.z()) - 0.42});
        return std::min(slab, (p - Eigen::Vector3d(0, 0.1, 0)).norm() - ball);
      },
      [](const Eigen::Vector3d&) { return Eigen::Vector3d(0.5, 0.5, 0.5); });
}

TEST(MeshExtraction, FloorsHaveFewTrianglesAndKeepTheirOutline) {
  MeshExtractionOptions options = as_given();
  options.still_simplification = 0.003;
  const host::Mesh waves = mesh_of(floor_field(0), options);
  options.flat_simplification = 0.02;
  const host::Mesh floor = mesh_of(floor_field(0), options);
  EXPECT_LT(5 * floor.faces.size(), waves.faces.size());
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : floor.positions) box.extend(p);
  EXPECT_NEAR(box.max().x(), 0.42F, 0.02F);
  EXPECT_NEAR(box.min().z(), -0.42F, 0.02F);
  EXPECT_EQ(mesh_of(floor_field(0.15), options).faces.size(), [&] {
    options.flat_simplification = 0;
    return mesh_of(floor_field(0.15), options).faces.size();
  }()) << "it is not flat with something on it";
}

TEST(FlatSurface, WhatNoCameraSawIsSmoothedButForItsRim) {
  const fields::Field field = floor_field(0);
  Triangles triangles = surface_nets(FieldSampler(field), std::log(2.0) / field.config.cell_size(), 48, Progress());
  const Triangles given = triangles;
  fields::Confidence confidence(field.occupancy);
  for (auto& levels : confidence.levels())
    for (std::size_t n = 0; n < levels.size(); ++n)
      levels[n] = fields::Confidence::normal(n).y() > -0.1F ? fields::Confidence::kMax : 0; // seen from above
  smooth_unseen(field.config.box, confidence, triangles);
  double above = 0, below = 0;
  std::vector<double> heights;
  for (std::size_t v = 0; v < given.positions.size(); ++v) {
    const Eigen::Vector3d& p = given.positions[v];
    const double way = (triangles.positions[v] - p).norm();
    if (p.y() > 0.02) above = std::max(above, way);
    below = std::max(below, way);
    if (p.cwiseAbs().maxCoeff() < 0.2 && triangles.positions[v].y() < -0.005)
      heights.push_back(triangles.positions[v].y());
  }
  EXPECT_EQ(above, 0);
  EXPECT_GT(below, 0.003);
  ASSERT_GT(heights.size(), 100U);
  const auto [low, high] = std::ranges::minmax(heights);
  EXPECT_LT(high - low, 0.01) << "of 2 cm from crest to trough";
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
