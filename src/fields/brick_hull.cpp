#include "fields/brick_hull.h"

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
constexpr double kTorn = 1.7;
constexpr std::size_t kChunk = 256;

HullFace face_of(const std::array<std::uint32_t, 8>& corners, std::size_t direction) {
  HullFace face{};
  for (std::size_t i = 0; i < 4; ++i) face[i] = corners[static_cast<std::size_t>(kFaces[direction][i])];
  return face;
}

PosedHull::Corner carried(const SE3& transform, const Eigen::Vector3d& canonical) {
  return {transform * canonical, transform.linear().transpose().cast<float>()};
}

} // namespace

BrickHull::BrickHull(const DensityBricks& bricks, const FieldBox& box)
    : cell_side_(box.side * kCellSide / bricks.resolution()) {
  std::vector<std::array<int, 3>> places;
  cells_of_brick_.assign(bricks.count(), {-1, -1, -1, -1, -1, -1, -1, -1});
  for (std::size_t b = 0; b < bricks.count(); ++b) {
    for (int octant = 0; octant < 8; ++octant) {
      const std::array<int, 3> half{octant & 1, (octant >> 1) & 1, octant >> 2};
      const std::array<int, 3> low{half[0] * kCellSide, half[1] * kCellSide, half[2] * kCellSide};
      if (bricks.largest(b, low, kCellSide) < DensityBricks::kVisible) continue;
      cells_of_brick_[b][static_cast<std::size_t>(octant)] = static_cast<std::int32_t>(places.size());
      const auto& brick = bricks.place(b);
      places.push_back({2 * brick[0] + half[0], 2 * brick[1] + half[1], 2 * brick[2] + half[2]});
    }
  }
  const auto corners_per_side = 2 * static_cast<std::uint64_t>(bricks.bricks_per_side()) + 1;
  std::unordered_map<std::uint64_t, std::uint32_t> numbers;
  numbers.reserve(2 * places.size());
  for (const auto& [x, y, z] : places) {
    Cell cell{};
    for (int c = 0; c < 8; ++c) {
      const std::array<int, 3> at{x + (c & 1), y + ((c >> 1) & 1), z + (c >> 2)};
      const std::uint64_t key =
          (static_cast<std::uint64_t>(at[2]) * corners_per_side + static_cast<std::uint64_t>(at[1])) *
              corners_per_side +
          static_cast<std::uint64_t>(at[0]);
      const auto [found, is_new] = numbers.try_emplace(key, static_cast<std::uint32_t>(corners_.size()));
      if (is_new) {
        const Eigen::Vector3d lattice = Eigen::Vector3d(at[0], at[1], at[2]) * kCellSide;
        corners_.emplace_back(box.origin + lattice * (box.side / bricks.resolution()));
        places_.emplace_back(lattice.cast<float>());
      }
      cell.corners[static_cast<std::size_t>(c)] = found->second;
    }
    cell.neighbours = {cell_at(bricks, x - 1, y, z), cell_at(bricks, x + 1, y, z), cell_at(bricks, x, y - 1, z),
                       cell_at(bricks, x, y + 1, z), cell_at(bricks, x, y, z - 1), cell_at(bricks, x, y, z + 1)};
    cells_.push_back(cell);
  }
  faces_ = faces_of(std::vector<std::uint8_t>(cells_.size(), 1));
}

std::int32_t BrickHull::cell_at(const DensityBricks& bricks, int x, int y, int z) const {
  if (x < 0 || y < 0 || z < 0) return -1;
  const int brick = bricks.brick_at(x / 2, y / 2, z / 2);
  return brick < 0 ? -1
                   : cells_of_brick_[static_cast<std::size_t>(brick)]
                                    [static_cast<std::size_t>((x & 1) | (y & 1) << 1 | (z & 1) << 2)];
}

std::vector<HullFace> BrickHull::faces_of(const std::vector<std::uint8_t>& kept) const {
  std::vector<std::vector<HullFace>> parts(chunk_count(cells_.size(), kChunk));
  parallel_for(cells_.size(), kChunk, [&](const Chunk& chunk) {
    for (std::size_t c = chunk.begin; c < chunk.end; ++c) {
      if (kept[c] == 0) continue;
      for (std::size_t d = 0; d < 6; ++d) {
        const std::int32_t neighbour = cells_[c].neighbours[d];
        if (neighbour < 0 || kept[static_cast<std::size_t>(neighbour)] == 0)
          parts[chunk.index].push_back(face_of(cells_[c].corners, d));
      }
    }
  });
  std::vector<HullFace> faces;
  for (const auto& part : parts) faces.insert(faces.end(), part.begin(), part.end());
  return faces;
}

void BrickHull::follow(const tracking::DeformationGraph& graph) {
  influences_.resize(corners_.size());
  parallel_for(corners_.size(), kChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) influences_[i] = graph.influence(corners_[i]);
  });
  middle_influences_.resize(cells_.size());
  parallel_for(cells_.size(), kChunk, [&](const Chunk& chunk) {
    for (std::size_t c = chunk.begin; c < chunk.end; ++c) middle_influences_[c] = graph.influence(middle(c));
  });
}

PosedHull::PosedHull(const BrickHull& hull, const tracking::Warp& warp)
    : corners_(hull.corners().size()), places_(hull.places()) {
  carry_corners(hull, warp);
  std::vector<std::uint8_t> whole(hull.cells().size());
  cells_.resize(whole.size());
  parallel_for(whole.size(), kChunk, [&](const Chunk& chunk) {
    for (std::size_t c = chunk.begin; c < chunk.end; ++c) {
      cells_[c] = hull.cells()[c].corners;
      whole[c] = is_whole(cells_[c], hull.cell_side()) ? 1 : 0;
    }
  });
  faces_ = hull.faces_of(whole);
  std::vector<std::size_t> torn;
  for (std::size_t c = 0; c < whole.size(); ++c) {
    if (whole[c] == 0 && hull.middle_influences()[c].count > 0) torn.push_back(c);
  }
  carry_rigidly(hull, torn, warp);
}

void PosedHull::carry_corners(const BrickHull& hull, const tracking::Warp& warp) {
  parallel_for(corners_.size(), kChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      if (hull.influences()[i].count == 0) {
        corners_[i] = {Eigen::Vector3d::Constant(std::nan("")), Eigen::Matrix3f::Identity()};
      } else {
        corners_[i] = carried(warp.at(hull.influences()[i]), hull.corners()[i]);
      }
    }
  });
}

bool PosedHull::is_whole(const std::array<std::uint32_t, 8>& cell, double side) const {
  for (const auto& [a, b] : kEdges) {
    const double length =
        (corners_[cell[static_cast<std::size_t>(a)]].world - corners_[cell[static_cast<std::size_t>(b)]].world).norm();
    if (!(length < kTorn * side && length > side / kTorn)) return false; // also of NaN
  }
  return true;
}

// Each of these cells for itself, with corners and faces of its own.
void PosedHull::carry_rigidly(const BrickHull& hull, std::span<const std::size_t> cells, const tracking::Warp& warp) {
  const std::size_t first_corner = corners_.size();
  const std::size_t first_face = faces_.size();
  corners_.resize(first_corner + 8 * cells.size());
  places_.resize(corners_.size());
  faces_.resize(first_face + kFaces.size() * cells.size());
  parallel_for(cells.size(), kChunk, [&](const Chunk& chunk) {
    for (std::size_t k = chunk.begin; k < chunk.end; ++k) {
      std::array<std::uint32_t, 8>& cell = cells_[cells[k]];
      const SE3 transform = warp.at(hull.middle_influences()[cells[k]]);
      for (std::size_t i = 0; i < 8; ++i) {
        const std::size_t corner = first_corner + 8 * k + i;
        corners_[corner] = carried(transform, hull.corners()[cell[i]]);
        places_[corner] = hull.places()[cell[i]];
        cell[i] = static_cast<std::uint32_t>(corner);
      }
      for (std::size_t d = 0; d < kFaces.size(); ++d) {
        faces_[first_face + kFaces.size() * k + d] = face_of(cell, d);
      }
    }
  });
}

} // namespace kinora::fields
