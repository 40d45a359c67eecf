// Hulls that are carried, seen and rasterised many points at a time, against the same for one, on every instruction
// set.
#include <gtest/gtest.h>

#include <optional>

#include "fields/network/field_batch.h"
#include "fields/network/hash_grid.h"
#include "fields/rendering/proxy_mesh.h"
#include "fields/rendering/rasterizer.h"
#include "fields/rendering/shading.h"
#include "fields/scenes/drawn_scene.h"
#include "fields/scenes/random_field.h"
#include "support/every_instruction_set.h"

namespace kinora::fields {
namespace {

class ProxyMeshTest : public OnEveryInstructionSet {};

/// Turns nodes about the vertical, by `twist` radians per metre, a long way off.
motion::Warp twisted(const std::shared_ptr<const motion::DeformationGraph>& graph, double twist) {
  std::vector<DualQuaternion> nodes;
  for (const Eigen::Vector3d& node : graph->nodes()) {
    SE3 rotation = SE3::Identity();
    rotation.rotate(Eigen::AngleAxisd(twist * node.y(), Eigen::Vector3d::UnitY()));
    rotation.pretranslate(Eigen::Vector3d(3, -1, 40));
    nodes.push_back(DualQuaternion::from(rotation));
  }
  return {graph, nodes};
}

struct TwistedBall {
  std::shared_ptr<const motion::DeformationGraph> graph = testing::graph_of_box();
  motion::Warp warp = twisted(graph, 2);
  DensityBricks bricks{testing::painted_field(testing::kBox, testing::PaintedBall{})};
  ProxyMesh proxy_mesh{bricks, testing::kBox};
  TwistedBall() { proxy_mesh.bind_to(*graph); }
};

const TwistedBall& twisted_ball() {
  static const TwistedBall ball;
  return ball;
}

TEST_P(ProxyMeshTest, CornersAreWhereTheWarpCarriesThem) {
  const TwistedBall& ball = twisted_ball();
  const PosedProxyMesh posed(ball.proxy_mesh, ball.warp);
  ASSERT_GT(ball.proxy_mesh.corner_count(), 100U);
  constexpr std::size_t kStep = 7; // every lane of every vector has its turn
  for (std::size_t i = 0; i < ball.proxy_mesh.corner_count(); i += kStep) {
    const Eigen::Vector3d canonical = ball.proxy_mesh.to_canonical(ball.proxy_mesh.positions()[i]);
    const Eigen::Vector3d expected = ball.warp.to_world(canonical).value() - posed.origin();
    ASSERT_LT((posed.corners().world[i].cast<double>() - expected).norm(), 1e-5) << i;
    const Eigen::Matrix3d rotation = Eigen::Quaternionf(posed.corners().rotation[i]).toRotationMatrix().cast<double>();
    ASSERT_LT((rotation - ball.warp.at(canonical)->linear()).norm(), 1e-5) << i;
  }
}

TEST_P(ProxyMeshTest, PlacesAreRefinedToWhereTheMotionHasThem) {
  const TwistedBall& ball = twisted_ball();
  const PosedProxyMesh posed(ball.proxy_mesh, ball.warp);
  const kernels::CellMotion motion{
      ball.bricks.index(),
      ball.bricks.bricks_per_side(),
      ball.proxy_mesh.cells_of_brick().front().data(),
      reinterpret_cast<const std::int32_t*>(ball.proxy_mesh.cells().front().corners.data()),
      sizeof(ProxyMesh::Cell) / sizeof(std::int32_t),
      posed.split_corners().data(),
      posed.corners().world.data()};
  const std::size_t n = std::min<std::size_t>(ball.proxy_mesh.cells().size(), 101);
  kernels::PointLanes points, positions;
  points.resize(n);
  positions.resize(n);
  for (std::size_t c = 0; c < n; ++c) {
    Eigen::Vector3f middle = Eigen::Vector3f::Zero();
    for (std::size_t k = 0; k < 8; ++k) middle += posed.corners().world[posed.corner(c, k)] / 8;
    points.set(c, middle);
    positions.set(c, ball.proxy_mesh.middle(c) + Eigen::Vector3f(0.9F, -0.7F, 0.5F));
  }
  kernels::refine(motion, n, points, positions);
  for (std::size_t c = 0; c < n; ++c) EXPECT_LT((positions.at(c) - ball.proxy_mesh.middle(c)).norm(), 0.05F) << c;
}

/// A triangle and the rays that meet it, one at a time.
class PlainTriangle {
public:
  PlainTriangle(const std::vector<Eigen::Vector3f>& corners, const std::array<std::uint32_t, 3>& numbers) {
    for (int k = 0; k < 3; ++k) vertices_.col(k) = corners[numbers[static_cast<std::size_t>(k)]].cast<double>();
    inverse_ = vertices_.inverse();
  }
  bool is_seen() const { return vertices_.determinant() < 0; }
  /// Depth at which a ray (x, y, 1) meets it; 0 if it does not, nothing if it passes so near an edge that rounding may
  /// decide.
  std::optional<double> depth_of(const Eigen::Vector3d& ray) const {
    const Eigen::Vector3d shares = inverse_ * ray;
    const double depth = 1 / shares.sum();
    if (std::abs(shares.minCoeff() * depth) < 1e-3) return std::nullopt;
    return depth > 0 && shares.minCoeff() > 0 ? depth : 0;
  }

private:
  Eigen::Matrix3d vertices_, inverse_;
};

TEST_P(ProxyMeshTest, FacesSeenFromOutsideAreEnteredWhereTheirPlaneIs) {
  const Intrinsics intrinsics{40, 30, 30, 30, 19.5, 14.5};
  Random random(5);
  std::vector<Eigen::Vector3f> corners;
  std::vector<ProxyFace> faces;
  for (std::uint32_t f = 0; f < 300; ++f) { // squares, some behind the camera, some turned away
    const Eigen::Vector3d centre(random.normal(), random.normal(), 3 * random.normal());
    const Eigen::Matrix3d rotation =
        Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()).normalized().matrix();
    for (const auto& [x, y] : {std::pair{0, 0}, std::pair{1, 0}, std::pair{1, 1}, std::pair{0, 1}}) {
      corners.emplace_back((centre + rotation * Eigen::Vector3d(x, y, 0)).cast<float>());
    }
    faces.push_back({4 * f, 4 * f + 1, 4 * f + 2, 4 * f + 3});
  }
  const TriangleBins bins(intrinsics, std::array{TriangleBins::Mesh{corners, faces}});
  constexpr int kTile = TriangleBins::kTile;
  std::size_t drawn = 0, met = 0;
  for (int row = 0; row < bins.rows(); ++row) {
    for (int column = 0; column < bins.columns(); ++column) {
      const TileRays rays = tile_rays(intrinsics, kTile * column, kTile * row);
      for (const std::uint32_t number : bins.of_tile(column, row)) {
        Entries entries;
        rasterize(bins.triangle(number), number, rays, entries);
        const PlainTriangle plain(corners, bins.triangle(number).corners);
        for (int p = 0; p < kTile * kTile; ++p) {
          const int u = kTile * column + p % kTile;
          const int v = kTile * row + p / kTile;
          const auto depth = plain.depth_of(intrinsics.unproject(u, v, 1));
          if (u >= intrinsics.width || v >= intrinsics.height || !depth) continue;
          const auto pixel = static_cast<std::size_t>(p);
          ASSERT_EQ(entries.count(pixel), *depth > 0 ? 1U : 0U) << number << ' ' << u << ' ' << v;
          if (!(*depth > 0)) continue;
          EXPECT_NEAR(entries.at(pixel, 0).depth, *depth, 1e-3 * *depth);
          ++drawn;
        }
      }
    }
  }
  for (const ProxyFace& face : faces) {
    for (const std::size_t second : {std::size_t{1}, std::size_t{2}}) {
      const PlainTriangle plain(corners, {face[0], face[second], face[second + 1]});
      for (int p = 0; plain.is_seen() && p < intrinsics.width * intrinsics.height; ++p) {
        const int v = p / intrinsics.width;
        const auto depth = plain.depth_of(intrinsics.unproject(p % intrinsics.width, v, 1));
        met += depth && *depth > 0 ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(drawn, met) << "no triangle is left out";
  EXPECT_GT(met, 1000U);
}

TEST_P(ProxyMeshTest, ColoursOfSurfacesAreThoseOfTheWholeNets) {
  const Field field = testing::random_field(8, 0.5F);
  const std::vector<GridLevel> levels = grid_levels(field.config);
  constexpr std::size_t kPoints = 77;
  Random random(2);
  std::vector<float> x, y, z;
  for (std::size_t i = 0; i < kPoints; ++i) {
    for (std::vector<float>* values : {&x, &y, &z}) values->push_back(random.uniform());
  }
  const kernels::Points points{x.data(), y.data(), z.data(), kPoints};
  PointBatch whole, hidden;
  evaluate_points(field, levels, points, whole);
  evaluate_hidden(field, levels, points, hidden);
  ColorBatch expected, colors;
  const std::vector<float> vectors = vector_matrix(field);
  for (std::size_t i = 0; i < kPoints; ++i) {
    const float* features = whole.geometry.data() + i * FieldConfig::kGeometry;
    expected.input.insert(expected.input.end(), features + 1, features + FieldConfig::kGeometry);
    expected.input.push_back(1);
    const Rotation rotation = testing::random_rotation(random);
    rotate_vectors(rotation, expected.input.data() + i * FieldConfig::kGeometry);
    const float* row = hidden.hidden.data() + i * FieldConfig::kHidden;
    colors.input.insert(colors.input.end(), row, row + FieldConfig::kHidden);
    colors.input.push_back(1);
    std::array<float, kSurfaceVectors> rotated{};
    for (std::size_t k = 0; k < vectors.size(); ++k)
      rotated[k % kSurfaceVectors] += row[k / kSurfaceVectors] * vectors[k];
    rotate_vectors(rotation, rotated.data());
    colors.input.insert(colors.input.end(), rotated.begin(), rotated.end());
  }
  evaluate_colors(field, kPoints, expected);
  evaluate_surface_colors(field, surface_matrix(field), kPoints, colors);
  float largest = 0;
  for (std::size_t i = 0; i < kPoints * FieldConfig::kColorOutputs; ++i) {
    largest = std::max(largest, std::abs(expected.output[i]));
    EXPECT_NEAR(colors.output[i], expected.output[i], 1e-4F * (1 + std::abs(expected.output[i])));
  }
  EXPECT_GT(largest, 1e-3F);
}

TEST_P(ProxyMeshTest, ColoursAreTheSigmoidOfTheNetsOutputs) {
  constexpr std::size_t kRows = 37;
  Random random(3);
  std::vector<float> outputs;
  for (std::size_t i = 0; i < kRows * FieldConfig::kColorOutputs; ++i) {
    outputs.push_back(i % 7 == 0 ? 1e4F * (random.uniform() - 0.5F) : 20 * (random.uniform() - 0.5F));
  }
  std::vector<float> colors(4 * kRows);
  kernels::to_colors(outputs.data(), kRows, colors.data());
  for (std::size_t row = 0; row < kRows; ++row) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float output = outputs[row * FieldConfig::kColorOutputs + c];
      EXPECT_NEAR(colors[4 * row + c], 1 / (1 + std::exp(-output)), 1e-6F) << output;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, ProxyMeshTest, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::fields
