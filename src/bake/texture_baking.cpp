#include "bake/texture_baking.h"

#include <algorithm>
#include <cmath>

namespace kinora::bake {
namespace {

/// A pixel and the place on a face that it shows.
struct Texel {
  int x, y;
  std::uint32_t face;
  Eigen::Vector3d weights; // of the face's corners
};

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

class TexelFinder {
public:
  explicit TexelFinder(const TextureAtlas& atlas) : atlas_(atlas), taken_(atlas.width, atlas.height) {
    // First what lies in a triangle, then what one touches: slivers and edges.
    for (const double reach : {0.0, 1.0}) {
      for (std::uint32_t f = 0; f < atlas.faces.size(); ++f) visit(f, reach);
    }
  }
  const std::vector<Texel>& texels() const { return texels_; }

private:
  void visit(std::uint32_t f, double reach) {
    std::array<Eigen::Vector2d, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = atlas_.coordinates[atlas_.faces[f][k]].cast<double>();
    const double area = cross(corners[1] - corners[0], corners[2] - corners[0]);
    if (area == 0) return;
    const Eigen::Vector2d low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
    const Eigen::Vector2d high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
    const auto first = [reach](double v) { return std::max(0, static_cast<int>(std::floor(v - reach))); };
    const auto last = [reach](double v, int n) { return std::min(n - 1, static_cast<int>(std::floor(v + reach))); };
    for (int y = first(low.y()); y <= last(high.y(), atlas_.height); ++y) {
      for (int x = first(low.x()); x <= last(high.x(), atlas_.width); ++x) {
        if (taken_.at(x, y) != 0) continue;
        const Eigen::Vector2d p(x + 0.5, y + 0.5);
        Eigen::Vector3d weights;
        for (int k = 0; k < 3; ++k) {
          const auto a = static_cast<std::size_t>((k + 1) % 3);
          const auto b = static_cast<std::size_t>((k + 2) % 3);
          weights[k] = cross(corners[b] - corners[a], p - corners[a]) / area;
        }
        weights = weights.cwiseMax(0);
        weights /= weights.sum();
        Eigen::Vector2d nearest = Eigen::Vector2d::Zero();
        for (int k = 0; k < 3; ++k) nearest += weights[k] * corners[static_cast<std::size_t>(k)];
        if ((nearest - p).squaredNorm() > reach * reach + 1e-9) continue;
        taken_.at(x, y) = 1;
        texels_.push_back({x, y, f, weights});
      }
    }
  }

  const TextureAtlas& atlas_;
  Image<std::uint8_t> taken_;
  std::vector<Texel> texels_;
};

/// Each pixel that is not set and has a neighbour that is takes the mean of those.
void spread(ColorImage& texture, Image<std::uint8_t>& set) {
  const Image<std::uint8_t> before = set;
  for (int y = 0; y < texture.height(); ++y) {
    for (int x = 0; x < texture.width(); ++x) {
      if (before.at(x, y) != 0) continue;
      std::array<int, 3> sums{};
      int count = 0;
      for (int k = 0; k < 9; ++k) {
        const int u = x + k % 3 - 1;
        const int v = y + k / 3 - 1;
        if (!before.contains(u, v) || before.at(u, v) == 0) continue;
        ++count;
        for (std::size_t c = 0; c < 3; ++c) sums[c] += texture.pixel(u, v)[c];
      }
      if (count == 0) continue;
      for (std::size_t c = 0; c < 3; ++c) texture.pixel(x, y)[c] = static_cast<std::uint8_t>(sums[c] / count);
      set.at(x, y) = 1;
    }
  }
}

} // namespace

ColorImage bake_texture(const TextureAtlas& atlas, const Triangles& triangles, std::span<const Eigen::Vector3d> normals,
                        const FieldSampler& sampler, const motion::Motion& motion, double before,
                        const Progress& progress) {
  const TexelFinder finder(atlas);
  const std::vector<Texel>& texels = finder.texels();
  std::vector<SurfacePoint> points;
  points.reserve(texels.size());
  for (const Texel& texel : texels) {
    SurfacePoint point{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = triangles.faces[texel.face][static_cast<std::size_t>(k)];
      point.position += texel.weights[k] * triangles.positions[v];
      point.normal += texel.weights[k] * normals[v];
    }
    point.normal.normalize();
    points.push_back(point);
  }
  const auto colors = surface_colors(sampler, motion, points, before, progress);
  std::array<std::uint64_t, 3> sums{};
  for (const auto& color : colors) {
    for (std::size_t c = 0; c < 3; ++c) sums[c] += color[c];
  }
  ColorImage texture(atlas.width, atlas.height, 3);
  Image<std::uint8_t> set(atlas.width, atlas.height);
  for (std::size_t i = 0; i < texture.pixel_count(); ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      texture.data()[3 * i + c] = static_cast<std::uint8_t>(sums[c] / std::max<std::size_t>(1, colors.size()));
  }
  for (std::size_t i = 0; i < texels.size(); ++i) {
    std::copy(colors[i].begin(), colors[i].end(), texture.pixel(texels[i].x, texels[i].y));
    set.at(texels[i].x, texels[i].y) = 1;
  }
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) spread(texture, set);
  return texture;
}

} // namespace kinora::bake
