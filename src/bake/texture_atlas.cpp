#include "bake/texture_atlas.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "bake/texture_charts.h"
#include "core/error.h"

namespace kinora::bake {
namespace {

constexpr int kApart = 2; ///< pixels between charts

struct Packing {
  int width = 0;
  int height = 0;
  std::vector<Eigen::Vector2i> corners; ///< upper left pixel of each chart
};

Eigen::Vector2i pixels_of(const Chart& chart, double pixel) {
  const auto side = [pixel](double metres) { return static_cast<int>(std::ceil(metres / pixel)) + kApart; };
  return {side(chart.size.x()), side(chart.size.y())};
}

int multiple_of_four(int n) { return (n + 3) / 4 * 4; }

/// Rows of charts, the highest first.
Packing pack(const std::vector<Chart>& charts, const std::vector<std::size_t>& order, double pixel) {
  double area = 0;
  int widest = 0;
  for (const Chart& chart : charts) {
    const Eigen::Vector2i size = pixels_of(chart, pixel);
    area += static_cast<double>(size.x()) * size.y();
    widest = std::max(widest, size.x());
  }
  Packing packing;
  packing.width = multiple_of_four(std::max(widest, static_cast<int>(std::ceil(std::sqrt(1.1 * area)))));
  packing.corners.resize(charts.size());
  Eigen::Vector2i pen(0, 0);
  int row = 0;
  for (const std::size_t i : order) {
    const Eigen::Vector2i size = pixels_of(charts[i], pixel);
    if (pen.x() + size.x() > packing.width) {
      pen = {0, pen.y() + row};
      row = 0;
    }
    packing.corners[i] = pen;
    pen.x() += size.x();
    row = std::max(row, size.y());
  }
  packing.height = multiple_of_four(std::max(4, pen.y() + row));
  return packing;
}

} // namespace

TextureAtlas texture_atlas(const Triangles& triangles, double pixel, int max_side, const Progress& progress) {
  const std::vector<Chart> charts = texture_charts(triangles, pixel, progress);
  std::vector<std::size_t> order(charts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&charts](std::size_t a, std::size_t b) { return charts[a].size.y() > charts[b].size.y(); });
  Packing packing = pack(charts, order, pixel);
  for (int attempt = 0; std::max(packing.width, packing.height) > max_side; ++attempt) {
    if (attempt == 100)
      throw Error(ErrorCode::kFailure, "the surface is in too many pieces for a texture so small; make it larger "
                                       "(-O texture=...) or the mesh coarser (-O error=...)");
    pixel *= std::max(1.02, 0.98 * std::max(packing.width, packing.height) / max_side);
    packing = pack(charts, order, pixel);
  }
  TextureAtlas atlas;
  atlas.width = packing.width;
  atlas.height = packing.height;
  atlas.faces.resize(triangles.faces.size());
  for (std::size_t i = 0; i < charts.size(); ++i) {
    std::map<std::uint32_t, std::uint32_t> numbers;
    for (std::size_t f = 0; f < charts[i].faces.size(); ++f) {
      const std::uint32_t face = charts[i].faces[f];
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t source = triangles.faces[face][k];
        const auto [entry, is_new] = numbers.try_emplace(source, static_cast<std::uint32_t>(atlas.sources.size()));
        atlas.faces[face][k] = entry->second;
        if (!is_new) continue;
        atlas.sources.push_back(source);
        // Pixels go down where the plane's second axis goes up.
        const Eigen::Vector2d place = charts[i].corners[f][k] / pixel;
        const double height = charts[i].size.y() / pixel;
        atlas.coordinates.emplace_back((packing.corners[i].cast<double>() +
                                        Eigen::Vector2d(place.x(), height - place.y()) +
                                        Eigen::Vector2d::Constant(0.5 * kApart))
                                           .cast<float>());
      }
    }
  }
  return atlas;
}

} // namespace kinora::bake
