#include "fields/rendering/row_by_row.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/parallel.h"
#include "core/row_lookup.h"

namespace kinora::fields {
namespace {

template <class T> const T* nearest(const Image<T>& image, const Eigen::Vector2d& at) {
  return image.pixel(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())));
}

// Colours count by their alpha.
std::array<std::uint8_t, 4> blended(const ColorImage& image, const Eigen::Vector2d& at) {
  const int x = std::min(static_cast<int>(at.x()), std::max(image.width() - 2, 0));
  const int y = std::min(static_cast<int>(at.y()), std::max(image.height() - 2, 0));
  const double right = at.x() - x, down = at.y() - y;
  std::array<double, 4> sum{};
  for (int dy = 0; dy < std::min(2, image.height()); ++dy) {
    for (int dx = 0; dx < std::min(2, image.width()); ++dx) {
      const std::uint8_t* color = image.pixel(x + dx, y + dy);
      const double weight = (dx == 0 ? 1 - right : right) * (dy == 0 ? 1 - down : down) * color[3];
      for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * color[c];
      sum[3] += weight;
    }
  }
  std::array<std::uint8_t, 4> result{};
  if (!(sum[3] > 0)) return result;
  for (std::size_t c = 0; c < 3; ++c) result[c] = static_cast<std::uint8_t>(std::lround(sum[c] / sum[3]));
  result[3] = static_cast<std::uint8_t>(std::lround(sum[3]));
  return result;
}

} // namespace

Picture read_row_by_row(const Picture& picture, const Intrinsics& intrinsics, const Twist& color, const Twist& depth) {
  Picture out = picture;
  const RowLookup of_color(picture.depth, intrinsics, color), of_depth(picture.depth, intrinsics, depth);
  parallel_for(static_cast<std::size_t>(intrinsics.height), 16, [&](const Chunk& chunk) {
    for (auto row = static_cast<int>(chunk.begin); row < static_cast<int>(chunk.end); ++row) {
      const Eigen::Matrix3f turn = exp_se3(-row_time(row, intrinsics.height) * color).linear().cast<float>();
      for (int u = 0; u < intrinsics.width; ++u) {
        const RowLookup::Place place = of_color.place_of(u, row);
        const auto shown = blended(picture.color, place.at);
        std::copy(shown.begin(), shown.end(), out.color.pixel(u, row));
        out.depth.at(u, row) = static_cast<float>(of_depth.place_of(u, row).depth);
        out.front.at(u, row) = *nearest(picture.front, place.at);
        if (!picture.confidence.empty()) out.confidence.at(u, row) = *nearest(picture.confidence, place.at);
        if (picture.normal.empty()) continue;
        const Eigen::Map<const Eigen::Vector3f> normal(nearest(picture.normal, place.at));
        Eigen::Map<Eigen::Vector3f>(out.normal.pixel(u, row)) = turn * normal;
      }
    }
  });
  return out;
}

} // namespace kinora::fields
