#include "fields/rasterizer.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace kinora::fields {
namespace {

constexpr float kBehind = 1e-3F; // metres: nearer corners have no place in the picture

// Share of a barycentric coordinate by which a ray may pass outside of a triangle, so that rounding leaves no gap
// between neighbours.
constexpr float kSlack = 1e-4F;

} // namespace

TriangleBins::TriangleBins(const Intrinsics& intrinsics)
    : intrinsics_(intrinsics), columns_((intrinsics.width + kTile - 1) / kTile),
      rows_((intrinsics.height + kTile - 1) / kTile) {}

bool TriangleBins::make(const std::array<const Eigen::Vector3f*, 3>& corners, HullTriangle& triangle) const {
  const Eigen::Vector3f& a = *corners[0];
  const Eigen::Vector3f& b = *corners[1];
  const Eigen::Vector3f& c = *corners[2];
  const Eigen::Vector3f bc = b.cross(c);
  const float determinant = a.dot(bc);
  if (!(determinant < 0)) return false; // seen from behind, or not finite
  float left = 0, top = 0;
  auto right = static_cast<float>(intrinsics_.width - 1), bottom = static_cast<float>(intrinsics_.height - 1);
  const int behind = (a.z() < kBehind ? 1 : 0) + (b.z() < kBehind ? 1 : 0) + (c.z() < kBehind ? 1 : 0);
  if (behind == 3) return false;
  if (behind == 0) {
    float low_u = right, high_u = 0, low_v = bottom, high_v = 0;
    for (const Eigen::Vector3f* corner : corners) {
      const float u =
          static_cast<float>(intrinsics_.fx) * corner->x() / corner->z() + static_cast<float>(intrinsics_.cx);
      const float v =
          static_cast<float>(intrinsics_.fy) * corner->y() / corner->z() + static_cast<float>(intrinsics_.cy);
      low_u = std::min(low_u, u);
      high_u = std::max(high_u, u);
      low_v = std::min(low_v, v);
      high_v = std::max(high_v, v);
    }
    left = std::max(left, std::ceil(low_u - 0.01F));
    right = std::min(right, std::floor(high_u + 0.01F));
    top = std::max(top, std::ceil(low_v - 0.01F));
    bottom = std::min(bottom, std::floor(high_v + 0.01F));
    if (!(left <= right && top <= bottom)) return false;
  }
  const Eigen::Vector3f ca = c.cross(a);
  const Eigen::Vector3f ab = a.cross(b);
  const float scale = 1 / determinant;
  triangle.rows = {{{bc.x() * scale, bc.y() * scale, bc.z() * scale},
                    {ca.x() * scale, ca.y() * scale, ca.z() * scale},
                    {ab.x() * scale, ab.y() * scale, ab.z() * scale}}};
  triangle.bounds = {static_cast<std::int16_t>(left), static_cast<std::int16_t>(right), static_cast<std::int16_t>(top),
                     static_cast<std::int16_t>(bottom)};
  return true;
}

void TriangleBins::add(std::uint8_t layer, std::span<const Eigen::Vector3f> corners, std::span<const HullFace> faces) {
  constexpr std::size_t kChunk = 1024;
  std::vector<std::vector<HullTriangle>> parts(chunk_count(faces.size(), kChunk));
  parallel_for(faces.size(), kChunk, [&](const Chunk& chunk) {
    for (std::size_t f = chunk.begin; f < chunk.end; ++f) {
      const HullFace& face = faces[f];
      for (const std::size_t second : {std::size_t{1}, std::size_t{2}}) {
        HullTriangle triangle{};
        triangle.corners = {face[0], face[second], face[second + 1]};
        triangle.layer = layer;
        const std::array<const Eigen::Vector3f*, 3> at{&corners[triangle.corners[0]], &corners[triangle.corners[1]],
                                                       &corners[triangle.corners[2]]};
        if (make(at, triangle)) parts[chunk.index].push_back(triangle);
      }
    }
  });
  for (const auto& part : parts) triangles_.insert(triangles_.end(), part.begin(), part.end());
}

void TriangleBins::sort() {
  const auto for_tiles = [&](const HullTriangle& triangle, const auto& visit) {
    for (int row = triangle.bounds[2] / kTile; row <= triangle.bounds[3] / kTile; ++row) {
      for (int column = triangle.bounds[0] / kTile; column <= triangle.bounds[1] / kTile; ++column) {
        const int tile = row * columns_ + column;
        visit(static_cast<std::size_t>(tile));
      }
    }
  };
  begin_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for (const HullTriangle& triangle : triangles_) {
    for_tiles(triangle, [&](std::size_t tile) { ++begin_[tile + 1]; });
  }
  for (std::size_t t = 1; t < begin_.size(); ++t) begin_[t] += begin_[t - 1];
  members_.resize(begin_.back());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
    for_tiles(triangles_[i], [&](std::size_t tile) { members_[next[tile]++] = i; });
  }
}

std::span<const std::uint32_t> TriangleBins::of_tile(int column, int row) const {
  const int number = row * columns_ + column;
  const auto tile = static_cast<std::size_t>(number);
  return std::span(members_).subspan(begin_[tile], begin_[tile + 1] - begin_[tile]);
}

void rasterize(const HullTriangle& triangle, std::uint32_t index, const Intrinsics& intrinsics, int left, int top,
               Entries& entries) {
  constexpr int kTile = TriangleBins::kTile;
  const int first_column = std::max<int>(triangle.bounds[0], left);
  const int last_column = std::min<int>(triangle.bounds[1], left + kTile - 1);
  const int first_row = std::max<int>(triangle.bounds[2], top);
  const int last_row = std::min<int>(triangle.bounds[3], top + kTile - 1);
  const auto fx = static_cast<float>(1 / intrinsics.fx);
  const auto fy = static_cast<float>(1 / intrinsics.fy);
  const auto cx = static_cast<float>(intrinsics.cx);
  const auto cy = static_cast<float>(intrinsics.cy);
  const auto& m = triangle.rows;
  for (int v = first_row; v <= last_row; ++v) {
    const float y = (static_cast<float>(v) - cy) * fy;
    std::array<float, 3> row{};
    for (std::size_t i = 0; i < 3; ++i) row[i] = m[i][1] * y + m[i][2];
    for (int u = first_column; u <= last_column; ++u) {
      const float x = (static_cast<float>(u) - cx) * fx;
      const float e0 = row[0] + m[0][0] * x;
      const float e1 = row[1] + m[1][0] * x;
      const float e2 = row[2] + m[2][0] * x;
      const float inverse_depth = e0 + e1 + e2;
      const float least = -kSlack * inverse_depth;
      if (!(inverse_depth > 0 && e0 >= least && e1 >= least && e2 >= least)) continue;
      entries.insert(static_cast<std::size_t>((v - top) * kTile + u - left), {1 / inverse_depth, index});
    }
  }
}

} // namespace kinora::fields
