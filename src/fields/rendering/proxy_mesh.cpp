#include "fields/rendering/proxy_mesh.h"

#include <cmath>
#include <unordered_map>

#include "core/parallel.h"

namespace kinora::fields {
namespace {

/// Per direction (−x, +x, −y, …) the corners of a cell's face, counterclockwise from outside.
constexpr std::array<std::array<int, 4>, 6> kFaces{
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
constexpr std::array<std::array<int, 2>, 12> kEdges{
    {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};
/// Edges of a cell that are longer or shorter by this factor tell that it is torn.
constexpr float kMaxStretch = 1.7F;
constexpr std::size_t kChunk = 1024;

ProxyFace face_of(const std::array<std::uint32_t, 8>& corners, std::size_t direction) {
  ProxyFace face{};
  for (std::size_t i = 0; i < 4; ++i) face[i] = corners[static_cast<std::size_t>(kFaces[direction][i])];
  return face;
}

} // namespace

ProxyMesh::ProxyMesh(const DensityBricks& bricks, const FieldBox& box)
    : origin_(box.origin), lattice_step_(box.side / bricks.resolution()) {
  std::vector<std::array<int, 3>> positions;
  cells_of_brick_.assign(bricks.count(), {-1, -1, -1, -1, -1, -1, -1, -1});
  for (std::size_t b = 0; b < bricks.count(); ++b) {
    for (int octant = 0; octant < 8; ++octant) {
      const std::array<int, 3> half{octant & 1, (octant >> 1) & 1, octant >> 2};
      const std::array<int, 3> low{half[0] * kCellSide, half[1] * kCellSide, half[2] * kCellSide};
      if (bricks.largest(b, low, kCellSide) < DensityBricks::kVisible) continue;
      cells_of_brick_[b][static_cast<std::size_t>(octant)] = static_cast<std::int32_t>(positions.size());
      const auto& brick = bricks.coordinates(b);
      positions.push_back({2 * brick[0] + half[0], 2 * brick[1] + half[1], 2 * brick[2] + half[2]});
    }
  }
  const auto corners_per_side = 2 * static_cast<std::uint64_t>(bricks.bricks_per_side()) + 1;
  std::unordered_map<std::uint64_t, std::uint32_t> numbers;
  numbers.reserve(2 * positions.size());
  cells_.reserve(positions.size());
  for (const auto& [x, y, z] : positions) {
    Cell cell{};
    for (int c = 0; c < 8; ++c) {
      const std::array<int, 3> at{x + (c & 1), y + ((c >> 1) & 1), z + (c >> 2)};
      const std::uint64_t key =
          (static_cast<std::uint64_t>(at[2]) * corners_per_side + static_cast<std::uint64_t>(at[1])) *
              corners_per_side +
          static_cast<std::uint64_t>(at[0]);
      const auto [found, is_new] = numbers.try_emplace(key, static_cast<std::uint32_t>(positions_.size()));
      if (is_new) positions_.emplace_back((Eigen::Vector3i(at[0], at[1], at[2]) * kCellSide).cast<float>());
      cell.corners[static_cast<std::size_t>(c)] = found->second;
    }
    cell.neighbours = {cell_at(bricks, x - 1, y, z), cell_at(bricks, x + 1, y, z), cell_at(bricks, x, y - 1, z),
                       cell_at(bricks, x, y + 1, z), cell_at(bricks, x, y, z - 1), cell_at(bricks, x, y, z + 1)};
    cells_.push_back(cell);
  }
  corner_count_ = positions_.size();
  positions_.resize(corner_count_ + kernels::kPadding, Eigen::Vector3f::Zero());
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    for (std::size_t d = 0; d < kFaces.size(); ++d) {
      if (cells_[c].neighbours[d] >= 0) continue;
      faces_.push_back(face_of(cells_[c].corners, d));
      cell_of_face_.push_back(static_cast<std::uint32_t>(c));
    }
  }
}

void ProxyMesh::forget_cells() {
  cells_ = {};
  cell_of_face_ = {};
}

std::int32_t ProxyMesh::cell_at(const DensityBricks& bricks, int x, int y, int z) const {
  if (x < 0 || y < 0 || z < 0) return -1;
  const int brick = bricks.brick_at(x / 2, y / 2, z / 2);
  return brick < 0 ? -1
                   : cells_of_brick_[static_cast<std::size_t>(brick)]
                                    [static_cast<std::size_t>((x & 1) | (y & 1) << 1 | (z & 1) << 2)];
}

std::vector<ProxyFace> ProxyMesh::faces_of(const std::vector<std::uint8_t>& kept) const {
  std::vector<ProxyFace> faces;
  faces.reserve(faces_.size());
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if (kept[cell_of_face_[f]] != 0) faces.push_back(faces_[f]);
  }
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    if (kept[c] != 0) continue;
    for (std::size_t d = 0; d < kFaces.size(); ++d) {
      const std::int32_t neighbour = cells_[c].neighbours[d];
      if (neighbour < 0 || kept[static_cast<std::size_t>(neighbour)] == 0) continue;
      faces.push_back(face_of(cells_[static_cast<std::size_t>(neighbour)].corners, d ^ 1U)); // as that cell sees it
    }
  }
  return faces;
}

void ProxyMesh::bind_to(const motion::DeformationGraph& graph) {
  influences_ = kernels::Influences(corner_count_);
  parallel_for(corner_count_, kChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      influences_.set(i, graph.influence(to_canonical(positions_[i])));
    }
  });
  middle_influences_.resize(cells_.size());
  parallel_for(cells_.size(), kChunk, [&](const Chunk& chunk) {
    for (std::size_t c = chunk.begin; c < chunk.end; ++c) {
      middle_influences_[c] = graph.influence(to_canonical(middle(c)));
    }
  });
}

std::vector<std::uint8_t> ProxyMesh::born_bricks(const motion::UnbornNodes& unborn) const {
  if (unborn.empty()) return {};
  std::vector<std::uint8_t> born(cells_of_brick_.size(), 1);
  for (std::size_t b = 0; b < born.size(); ++b) {
    int cells = 0;
    int not_there = 0;
    for (const std::int32_t cell : cells_of_brick_[b]) {
      if (cell < 0) continue;
      ++cells;
      not_there += is_unborn(middle_influences_[static_cast<std::size_t>(cell)], unborn) ? 1 : 0;
    }
    if (2 * not_there > cells) born[b] = 0;
  }
  return born;
}

PosedProxyMesh::PosedProxyMesh(const ProxyMesh& proxy_mesh, const motion::Warp& warp,
                               const std::vector<std::uint8_t>& born)
    : proxy_mesh_(&proxy_mesh), origin_(Eigen::Vector3d::Zero()), positions_(proxy_mesh.positions()),
      split_corners_(proxy_mesh.cells().size(), -1) {
  for (const Eigen::Vector3d& node : warp.node_positions()) {
    origin_ += node / static_cast<double>(warp.node_positions().size());
  }
  const std::vector<motion::TransformRow> transforms =
      motion::transform_rows(warp.node_to_world(), proxy_mesh.origin(), origin_);
  corners_.world.resize(positions_.size());
  corners_.rotation.resize(positions_.size());
  parallel_for(proxy_mesh.corner_count(), kChunk, [&](const Chunk& chunk) {
    kernels::skin(proxy_mesh.influences(), transforms.data(), positions_.data(),
                  static_cast<float>(proxy_mesh.lattice_step()), chunk.begin, chunk.end, corners_);
  });
  std::vector<std::uint8_t> there(proxy_mesh.cells().size(), 1);
  for (std::size_t b = 0; b < born.size(); ++b) {
    if (born[b] != 0) continue;
    for (const std::int32_t cell : proxy_mesh.cells_of_brick()[b]) {
      if (cell >= 0) there[static_cast<std::size_t>(cell)] = 0;
    }
  }
  std::vector<std::uint8_t> whole(proxy_mesh.cells().size());
  parallel_for(whole.size(), kChunk, [&](const Chunk& chunk) {
    for (std::size_t c = chunk.begin; c < chunk.end; ++c) {
      whole[c] = there[c] != 0 && is_unbroken(proxy_mesh.cells()[c].corners) ? 1 : 0;
    }
  });
  faces_ = proxy_mesh.faces_of(whole);
  std::vector<std::uint32_t> torn;
  for (std::uint32_t c = 0; c < whole.size(); ++c) {
    if (there[c] != 0 && whole[c] == 0 && proxy_mesh.middle_influences()[c].count > 0) torn.push_back(c);
  }
  skin_rigidly(torn, transforms);
}

bool PosedProxyMesh::is_unbroken(const std::array<std::uint32_t, 8>& cell) const {
  const auto side = static_cast<float>(ProxyMesh::kCellSide * proxy_mesh_->lattice_step());
  const float longest = kMaxStretch * side * kMaxStretch * side;
  const float shortest = side / kMaxStretch * side / kMaxStretch;
  for (const auto& [a, b] : kEdges) {
    const Eigen::Vector3f edge =
        corners_.world[cell[static_cast<std::size_t>(a)]] - corners_.world[cell[static_cast<std::size_t>(b)]];
    const float squared = edge.squaredNorm();
    if (!(squared < longest && squared > shortest)) return false; // also of NaN
  }
  return true;
}

// Each of these cells for itself, with corners and faces of its own.
void PosedProxyMesh::skin_rigidly(std::span<const std::uint32_t> cells,
                                  std::span<const motion::TransformRow> transforms) {
  const auto scale = static_cast<float>(proxy_mesh_->lattice_step());
  const std::size_t padded = cells.size() + kernels::kPadding;
  kernels::Influences influences(cells.size());
  std::vector<Eigen::Vector3f> middles(padded, Eigen::Vector3f::Zero());
  for (std::size_t k = 0; k < cells.size(); ++k) {
    influences.set(k, proxy_mesh_->middle_influences()[cells[k]]);
    middles[k] = proxy_mesh_->middle(cells[k]);
  }
  kernels::SkinnedPoints skinned{std::vector<Eigen::Vector3f>(padded), std::vector<Eigen::Vector4f>(padded)};
  kernels::skin(influences, transforms.data(), middles.data(), scale, 0, cells.size(), skinned);
  const std::size_t first_corner = proxy_mesh_->corner_count();
  const std::size_t corners = first_corner + 8 * cells.size() + kernels::kPadding;
  corners_.world.resize(corners);
  corners_.rotation.resize(corners);
  positions_.resize(corners, Eigen::Vector3f::Zero());
  faces_.reserve(faces_.size() + kFaces.size() * cells.size());
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const Eigen::Matrix3f rotation = scale * Eigen::Quaternionf(skinned.rotation[k]).toRotationMatrix();
    std::array<std::uint32_t, 8> split{};
    for (std::size_t i = 0; i < 8; ++i) {
      const std::size_t corner = first_corner + 8 * k + i;
      split[i] = static_cast<std::uint32_t>(corner);
      positions_[corner] = proxy_mesh_->positions()[proxy_mesh_->cells()[cells[k]].corners[i]];
      corners_.world[corner] = skinned.world[k] + rotation * (positions_[corner] - middles[k]);
      corners_.rotation[corner] = skinned.rotation[k];
    }
    split_corners_[cells[k]] = static_cast<std::int32_t>(split[0]);
    for (std::size_t d = 0; d < kFaces.size(); ++d) faces_.push_back(face_of(split, d));
  }
}

} // namespace kinora::fields
