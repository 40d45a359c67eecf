#include "fields/rendering/brick_hull.h"

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
constexpr float kTorn = 1.7F;
constexpr std::size_t kChunk = 1024;

HullFace face_of(const std::array<std::uint32_t, 8>& corners, std::size_t direction) {
  HullFace face{};
  for (std::size_t i = 0; i < 4; ++i) face[i] = corners[static_cast<std::size_t>(kFaces[direction][i])];
  return face;
}

} // namespace

BrickHull::BrickHull(const DensityBricks& bricks, const FieldBox& box)
    : origin_(box.origin), lattice_step_(box.side / bricks.resolution()) {
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
      const auto [found, is_new] = numbers.try_emplace(key, static_cast<std::uint32_t>(places_.size()));
      if (is_new) places_.emplace_back((Eigen::Vector3i(at[0], at[1], at[2]) * kCellSide).cast<float>());
      cell.corners[static_cast<std::size_t>(c)] = found->second;
    }
    cell.neighbours = {cell_at(bricks, x - 1, y, z), cell_at(bricks, x + 1, y, z), cell_at(bricks, x, y - 1, z),
                       cell_at(bricks, x, y + 1, z), cell_at(bricks, x, y, z - 1), cell_at(bricks, x, y, z + 1)};
    cells_.push_back(cell);
  }
  corner_count_ = places_.size();
  places_.resize(corner_count_ + kernels::kPadding, Eigen::Vector3f::Zero());
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    for (std::size_t d = 0; d < kFaces.size(); ++d) {
      if (cells_[c].neighbours[d] >= 0) continue;
      faces_.push_back(face_of(cells_[c].corners, d));
      cell_of_face_.push_back(static_cast<std::uint32_t>(c));
    }
  }
}

std::int32_t BrickHull::cell_at(const DensityBricks& bricks, int x, int y, int z) const {
  if (x < 0 || y < 0 || z < 0) return -1;
  const int brick = bricks.brick_at(x / 2, y / 2, z / 2);
  return brick < 0 ? -1
                   : cells_of_brick_[static_cast<std::size_t>(brick)]
                                    [static_cast<std::size_t>((x & 1) | (y & 1) << 1 | (z & 1) << 2)];
}

std::vector<HullFace> BrickHull::faces_of(const std::vector<std::uint8_t>& kept) const {
  std::vector<HullFace> faces;
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

void BrickHull::follow(const motion::DeformationGraph& graph) {
  influences_ = kernels::Influences(corner_count_);
  parallel_for(corner_count_, kChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      influences_.set(i, graph.influence(to_canonical(places_[i])));
    }
  });
  middle_influences_.resize(cells_.size());
  parallel_for(cells_.size(), kChunk, [&](const Chunk& chunk) {
    for (std::size_t c = chunk.begin; c < chunk.end; ++c) {
      middle_influences_[c] = graph.influence(to_canonical(middle(c)));
    }
  });
}

PosedHull::PosedHull(const BrickHull& hull, const motion::Warp& warp)
    : hull_(&hull), origin_(Eigen::Vector3d::Zero()), places_(hull.places()), own_corners_(hull.cells().size(), -1) {
  for (const Eigen::Vector3d& node : warp.node_positions()) {
    origin_ += node / static_cast<double>(warp.node_positions().size());
  }
  const std::vector<motion::TransformRow> transforms =
      motion::transform_rows(warp.node_to_world(), hull.origin(), origin_);
  corners_.world.resize(places_.size());
  corners_.rotation.resize(places_.size());
  parallel_for(hull.corner_count(), kChunk, [&](const Chunk& chunk) {
    kernels::carry(hull.influences(), transforms.data(), places_.data(), static_cast<float>(hull.lattice_step()),
                   chunk.begin, chunk.end, corners_);
  });
  std::vector<std::uint8_t> whole(hull.cells().size());
  parallel_for(whole.size(), kChunk, [&](const Chunk& chunk) {
    for (std::size_t c = chunk.begin; c < chunk.end; ++c) whole[c] = is_whole(hull.cells()[c].corners) ? 1 : 0;
  });
  faces_ = hull.faces_of(whole);
  std::vector<std::uint32_t> torn;
  for (std::uint32_t c = 0; c < whole.size(); ++c) {
    if (whole[c] == 0 && hull.middle_influences()[c].count > 0) torn.push_back(c);
  }
  carry_rigidly(torn, transforms);
}

bool PosedHull::is_whole(const std::array<std::uint32_t, 8>& cell) const {
  const auto side = static_cast<float>(BrickHull::kCellSide * hull_->lattice_step());
  const float longest = kTorn * side * kTorn * side;
  const float shortest = side / kTorn * side / kTorn;
  for (const auto& [a, b] : kEdges) {
    const Eigen::Vector3f edge =
        corners_.world[cell[static_cast<std::size_t>(a)]] - corners_.world[cell[static_cast<std::size_t>(b)]];
    const float squared = edge.squaredNorm();
    if (!(squared < longest && squared > shortest)) return false; // also of NaN
  }
  return true;
}

// Each of these cells for itself, with corners and faces of its own.
void PosedHull::carry_rigidly(std::span<const std::uint32_t> cells, std::span<const motion::TransformRow> transforms) {
  const auto scale = static_cast<float>(hull_->lattice_step());
  const std::size_t padded = cells.size() + kernels::kPadding;
  kernels::Influences influences(cells.size());
  std::vector<Eigen::Vector3f> middles(padded, Eigen::Vector3f::Zero());
  for (std::size_t k = 0; k < cells.size(); ++k) {
    influences.set(k, hull_->middle_influences()[cells[k]]);
    middles[k] = hull_->middle(cells[k]);
  }
  kernels::CarriedPoints carried{std::vector<Eigen::Vector3f>(padded), std::vector<Eigen::Vector4f>(padded)};
  kernels::carry(influences, transforms.data(), middles.data(), scale, 0, cells.size(), carried);
  const std::size_t first_corner = hull_->corner_count();
  const std::size_t corners = first_corner + 8 * cells.size() + kernels::kPadding;
  corners_.world.resize(corners);
  corners_.rotation.resize(corners);
  places_.resize(corners, Eigen::Vector3f::Zero());
  faces_.reserve(faces_.size() + kFaces.size() * cells.size());
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const Eigen::Matrix3f turn = scale * Eigen::Quaternionf(carried.rotation[k]).toRotationMatrix();
    std::array<std::uint32_t, 8> own{};
    for (std::size_t i = 0; i < 8; ++i) {
      const std::size_t corner = first_corner + 8 * k + i;
      own[i] = static_cast<std::uint32_t>(corner);
      places_[corner] = hull_->places()[hull_->cells()[cells[k]].corners[i]];
      corners_.world[corner] = carried.world[k] + turn * (places_[corner] - middles[k]);
      corners_.rotation[corner] = carried.rotation[k];
    }
    own_corners_[cells[k]] = static_cast<std::int32_t>(own[0]);
    for (std::size_t d = 0; d < kFaces.size(); ++d) faces_.push_back(face_of(own, d));
  }
}

} // namespace kinora::fields
