#include "fields/rendering/rasterizer.h"

#include "core/parallel.h"

namespace kinora::fields {
TriangleBins::TriangleBins(const Intrinsics& intrinsics, std::span<const Mesh> layers)
    : intrinsics_(intrinsics), columns_((intrinsics.width + kTile - 1) / kTile),
      rows_((intrinsics.height + kTile - 1) / kTile) {
  for (std::size_t l = 0; l < layers.size(); ++l) add(static_cast<std::uint8_t>(l), layers[l]);
  sort();
}

void TriangleBins::add(std::uint8_t layer, const Mesh& mesh) {
  constexpr std::size_t kFaces = kBatch / 2;
  const std::size_t first = batches_.size();
  batches_.resize(first + chunk_count(mesh.faces.size(), kFaces));
  parallel_for(mesh.faces.size(), kFaces, [&](const Chunk& chunk) {
    add_front(intrinsics_, mesh.corners.data(), mesh.faces.subspan(chunk.begin, chunk.end - chunk.begin), layer,
              batches_[first + chunk.index]);
  });
}

template <class Visit> void TriangleBins::for_triangles_and_tiles(const Visit& visit) const {
  for (std::uint32_t batch = 0; batch < batches_.size(); ++batch) {
    for (std::uint32_t i = 0; i < batches_[batch].size(); ++i) {
      const auto& bounds = batches_[batch][i].bounds;
      for (int row = bounds[2] / kTile; row <= bounds[3] / kTile; ++row) {
        for (int column = bounds[0] / kTile; column <= bounds[1] / kTile; ++column) {
          const int tile = row * columns_ + column;
          visit(batch * kBatch + i, static_cast<std::size_t>(tile));
        }
      }
    }
  }
}

void TriangleBins::sort() {
  begin_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for_triangles_and_tiles([&](std::uint32_t, std::size_t tile) { ++begin_[tile + 1]; });
  for (std::size_t t = 1; t < begin_.size(); ++t) begin_[t] += begin_[t - 1];
  members_.resize(begin_.back());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for_triangles_and_tiles([&](std::uint32_t triangle, std::size_t tile) { members_[next[tile]++] = triangle; });
}

std::span<const std::uint32_t> TriangleBins::of_tile(int column, int row) const {
  const int number = row * columns_ + column;
  const auto tile = static_cast<std::size_t>(number);
  return std::span(members_).subspan(begin_[tile], begin_[tile + 1] - begin_[tile]);
}

TileRays tile_rays(const Intrinsics& intrinsics, int left, int top) {
  const Eigen::Vector3f first = intrinsics.unproject(left, top, 1.0).cast<float>();
  return {
      left, top, first.x(), first.y(), static_cast<float>(1 / intrinsics.fx), static_cast<float>(1 / intrinsics.fy)};
}

} // namespace kinora::fields
