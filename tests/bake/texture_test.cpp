// Textured surfaces of fields whose shape and colour are known.
#include <gtest/gtest.h>

#include <map>

#include "bake/analytic_field.h"
#include "bake/mesh_extraction.h"
#include "core/error.h"
#include "core/parallel.h"

namespace kinora::bake {
namespace {

MeshExtractionOptions textured(int side = 512) {
  MeshExtractionOptions options;
  options.texture = side;
  options.simplification = 0.003;
  options.still_simplification = 0.003;
  return options;
}

host::Mesh mesh_of(const fields::Field& field, const MeshExtractionOptions& options) {
  return extract_mesh({"ball", 0, field, motion::Motion::still()}, options, Progress()).value_or(host::Mesh{});
}

TEST(Texture, HasTheFieldsColorWhereAFaceShowsIt) {
  const host::Mesh mesh = mesh_of(testing::ball_field(), textured());
  EXPECT_TRUE(mesh.colors.empty());
  ASSERT_EQ(mesh.texture_coordinates.size(), mesh.positions.size());
  std::size_t compared = 0;
  for (const auto& face : mesh.faces) {
    Eigen::Vector3f position = Eigen::Vector3f::Zero();
    Eigen::Vector2f place = Eigen::Vector2f::Zero();
    for (const std::uint32_t v : face) {
      position += mesh.positions[v] / 3;
      place += mesh.texture_coordinates[v] / 3;
    }
    if (std::abs(position.x()) < 0.05F) continue; // colours change here
    const std::uint8_t* color =
        mesh.texture.pixel(static_cast<int>(place.x() * static_cast<float>(mesh.texture.width())),
                           static_cast<int>(place.y() * static_cast<float>(mesh.texture.height())));
    const bool left = position.x() < 0;
    ASSERT_NEAR(color[0], 255 * (left ? 0.8 : 0.2), 6);
    ASSERT_NEAR(color[2], 255 * (left ? 0.3 : 0.8), 6);
    ++compared;
  }
  EXPECT_GT(compared, 100U);
}

TEST(Texture, NoTwoFacesShareAPixel) {
  const host::Mesh mesh = mesh_of(testing::ball_field(), textured());
  const int width = mesh.texture.width();
  Image<std::uint8_t> taken(width, mesh.texture.height());
  for (const auto& face : mesh.faces) {
    std::array<Eigen::Vector2d, 3> c;
    for (std::size_t k = 0; k < 3; ++k)
      c[k] =
          mesh.texture_coordinates[face[k]].cast<double>().cwiseProduct(Eigen::Vector2d(width, mesh.texture.height()));
    const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
    const double area = cross(c[1] - c[0], c[2] - c[0]);
    for (int y = 0; y < mesh.texture.height(); ++y) {
      for (int x = 0; x < width; ++x) {
        const Eigen::Vector2d p(x + 0.5, y + 0.5);
        bool inside = true;
        for (std::size_t k = 0; k < 3 && inside; ++k) inside = cross(c[(k + 1) % 3] - c[k], p - c[k]) / area > 1e-3;
        if (!inside) continue;
        ASSERT_EQ(taken.at(x, y)++, 0) << x << " " << y;
      }
    }
  }
}

TEST(Texture, IsNoLargerThanAskedForAndTheSameForAnyNumberOfThreads) {
  set_thread_count(1);
  const host::Mesh one = mesh_of(testing::ball_field(), textured(64));
  set_thread_count(3);
  const host::Mesh three = mesh_of(testing::ball_field(), textured(64));
  set_thread_count(0);
  EXPECT_LE(std::max(one.texture.width(), one.texture.height()), 64);
  EXPECT_TRUE(std::ranges::equal(one.texture.values(), three.texture.values()));
  EXPECT_EQ(one.positions, three.positions);
}

TEST(Texture, FlatSurfacesHaveFewTriangles) {
  const fields::Field slab = testing::field_of(
      [](const Eigen::Vector3d& p) { return (p.cwiseAbs() - Eigen::Vector3d(0.4, 0.1, 0.4)).maxCoeff(); },
      [](const Eigen::Vector3d&) { return Eigen::Vector3d(0.5, 0.5, 0.5); });
  MeshExtractionOptions plain;
  const std::size_t before = mesh_of(slab, plain).faces.size();
  const std::size_t after = mesh_of(slab, textured()).faces.size();
  EXPECT_GT(before, 5000U);
  EXPECT_LT(after, before / 10);
}

} // namespace
} // namespace kinora::bake
