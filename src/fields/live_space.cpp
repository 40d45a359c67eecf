#include "fields/live_space.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace kinora::fields {
namespace {

constexpr int kResolution = 128;
constexpr double kSmallestCell = 0.002; ///< metres
/// A cell's warp is taken as affine if its corners agree with that to this share of the cell's size; otherwise parts of
/// the surface that are apart in canonical space meet in it, and the part at its centre is followed rigidly.
constexpr double kAffineTolerance = 0.25;

std::vector<std::size_t> occupied_cells(const Occupancy& occupancy) {
  std::vector<std::size_t> cells;
  for (std::size_t w = 0; w < occupancy.words().size(); ++w) {
    for (int b = 0; b < 64; ++b) {
      if ((occupancy.words()[w] >> b) & 1) cells.push_back(w * 64 + static_cast<std::size_t>(b));
    }
  }
  return cells;
}

std::array<int, 3> coordinates(std::size_t cell, int resolution) {
  const auto r = static_cast<std::size_t>(resolution);
  return {static_cast<int>(cell % r), static_cast<int>(cell / r % r), static_cast<int>(cell / (r * r))};
}

Eigen::Vector3d centre_of(const std::array<int, 3>& cell, const FieldBox& box, int resolution) {
  return box.origin + box.side / resolution * (Eigen::Vector3d(cell[0], cell[1], cell[2]).array() + 0.5).matrix();
}

/// canonical + linear · (point − centre of the cell), in metres.
struct WayBack {
  Eigen::Vector3d canonical;
  Eigen::Matrix3d linear;
};

/// Canonical points of the corners of live cells, each found once.
class CornerTable {
public:
  CornerTable(const std::vector<std::size_t>& cells, const FieldBox& box, const tracking::Warp& warp)
      : index_(kSide * kSide * kSide, 0) {
    std::vector<std::size_t> corners;
    for (const std::size_t cell : cells) {
      for (int c = 0; c < 8; ++c) {
        const std::size_t at = corner_index(coordinates(cell, kResolution), c);
        if (index_[at] != 0) continue;
        corners.push_back(at);
        index_[at] = static_cast<std::uint32_t>(corners.size());
      }
    }
    canonical_.assign(corners.size(), Eigen::Vector3d::Constant(std::nan("")));
    parallel_for(corners.size(), 256, [&](const Chunk& chunk) {
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
        const auto [x, y, z] = coordinates(corners[i], static_cast<int>(kSide));
        const Eigen::Vector3d corner = box.origin + box.side / kResolution * Eigen::Vector3d(x, y, z);
        if (const auto canonical = warp.to_canonical(corner)) canonical_[i] = *canonical;
      }
    });
  }

  /// Least squares over the corners of a cell; nothing if one has no way back or they do not fit together.
  std::optional<WayBack> fit(const std::array<int, 3>& cell, double side) const {
    WayBack back{Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()};
    for (int c = 0; c < 8; ++c) back.canonical += at(cell, c) / 8;
    if (!back.canonical.allFinite()) return std::nullopt;
    // The corners' offsets are orthogonal: Σ offset · offsetᵀ = 2 · side² · identity.
    for (int c = 0; c < 8; ++c) {
      back.linear += (at(cell, c) - back.canonical) * offset_of(c, side).transpose() / (2 * side * side);
    }
    for (int c = 0; c < 8; ++c) {
      const double miss = (at(cell, c) - back.canonical - back.linear * offset_of(c, side)).norm();
      if (miss > kAffineTolerance * side) return std::nullopt;
    }
    return back;
  }

private:
  static constexpr std::size_t kSide = kResolution + 1;

  static std::size_t corner_index(const std::array<int, 3>& cell, int corner) {
    const auto along = [&](std::size_t axis) {
      const int steps = cell[axis] + ((corner >> static_cast<int>(axis)) & 1);
      return static_cast<std::size_t>(steps);
    };
    return (along(2) * kSide + along(1)) * kSide + along(0);
  }
  static Eigen::Vector3d offset_of(int corner, double side) {
    return side * Eigen::Vector3d((corner & 1) - 0.5, ((corner >> 1) & 1) - 0.5, (corner >> 2) - 0.5);
  }
  const Eigen::Vector3d& at(const std::array<int, 3>& cell, int corner) const {
    return canonical_[index_[corner_index(cell, corner)] - 1];
  }

  std::vector<std::uint32_t> index_; // per corner of the grid, 1 + index into canonical_
  std::vector<Eigen::Vector3d> canonical_;
};

} // namespace

LiveSpace::LiveSpace(const FieldConfig& config, const Occupancy& occupancy, const tracking::Warp& warp) {
  const Occupancy reached = mark_cells(config, occupancy, warp);
  distances_ = DistanceField(fit_maps(config, reached, warp));
}

// The live cells that a carried canonical cell may touch.
Occupancy LiveSpace::mark_cells(const FieldConfig& config, const Occupancy& occupancy, const tracking::Warp& warp) {
  const std::vector<std::size_t> cells = occupied_cells(occupancy);
  std::vector<Eigen::Vector3d> carried(cells.size(), Eigen::Vector3d::Constant(std::nan("")));
  parallel_for(cells.size(), 512, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const auto cell = coordinates(cells[i], occupancy.resolution());
      if (const auto p = warp.to_world(centre_of(cell, config.box, occupancy.resolution()))) carried[i] = *p;
    }
  });
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& p : carried) {
    if (p.allFinite()) bounds.extend(p);
  }
  Occupancy live(kResolution);
  if (bounds.isEmpty()) return live;
  const double canonical_cell = config.box.side / occupancy.resolution();
  const double reach = canonical_cell; // of a cell's corners from its centre, with room for stretching
  box_.side = std::max(bounds.sizes().maxCoeff() + 4 * reach, kSmallestCell * kResolution);
  box_.origin = bounds.center() - Eigen::Vector3d::Constant(0.5 * box_.side);
  const double scale = kResolution / box_.side;
  for (const Eigen::Vector3d& p : carried) {
    if (!p.allFinite()) continue;
    const Eigen::Vector3d at = (p - box_.origin) * scale;
    const auto low = (at.array() - reach * scale).floor().cwiseMax(0).cast<int>().eval();
    const auto high = (at.array() + reach * scale).floor().cwiseMin(kResolution - 1).cast<int>().eval();
    for (int z = low[2]; z <= high[2]; ++z) {
      for (int y = low[1]; y <= high[1]; ++y) {
        for (int x = low[0]; x <= high[0]; ++x) live.set(x, y, z);
      }
    }
  }
  return live;
}

// A map for each live cell that has a way back; returns those cells.
Occupancy LiveSpace::fit_maps(const FieldConfig& config, const Occupancy& live, const tracking::Warp& warp) {
  const std::vector<std::size_t> cells = occupied_cells(live);
  const CornerTable corners(cells, box_, warp);
  std::vector<Map> fitted(cells.size());
  std::vector<std::uint8_t> found(cells.size(), 0);
  parallel_for(cells.size(), 256, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const auto cell = coordinates(cells[i], kResolution);
      const Eigen::Vector3d centre = centre_of(cell, box_, kResolution);
      auto back = corners.fit(cell, box_.side / kResolution);
      if (!back) {
        const auto canonical = warp.to_canonical(centre);
        if (!canonical) continue;
        back = WayBack{*canonical, warp.at(*canonical)->linear().transpose()};
      }
      const Eigen::Matrix3d linear = back->linear * (box_.side / config.box.side);
      const Eigen::Vector3d offset =
          (back->canonical - config.box.origin) / config.box.side - linear * (centre - box_.origin) / box_.side;
      Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(fitted[i].linear.data()) = linear.cast<float>();
      Eigen::Map<Eigen::Vector3f>(fitted[i].offset.data()) = offset.cast<float>();
      found[i] = 1;
    }
  });
  cell_map_.assign(static_cast<std::size_t>(kResolution) * kResolution * kResolution, 0);
  Occupancy mapped(kResolution);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (found[i] == 0) continue;
    const auto [x, y, z] = coordinates(cells[i], kResolution);
    mapped.set(x, y, z);
    maps_.push_back(fitted[i]);
    cell_map_[cells[i]] = static_cast<std::uint32_t>(maps_.size());
  }
  return mapped;
}

const LiveSpace::Map* LiveSpace::map_at(const std::array<float, 3>& live) const {
  std::array<std::size_t, 3> cell{};
  for (std::size_t a = 0; a < 3; ++a) {
    const float scaled = live[a] * static_cast<float>(kResolution);
    if (!(scaled >= 0 && scaled < static_cast<float>(kResolution))) return nullptr;
    cell[a] = static_cast<std::size_t>(scaled);
  }
  const std::uint32_t map = cell_map_[(cell[2] * kResolution + cell[1]) * kResolution + cell[0]];
  return map == 0 ? nullptr : &maps_[map - 1];
}

std::array<float, 3> LiveSpace::Map::apply(const std::array<float, 3>& live) const {
  std::array<float, 3> canonical = offset;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) canonical[a] += linear[3 * a + b] * live[b];
  }
  return canonical;
}

FieldRay to_canonical(const LiveSpace::Map& map, const FieldRay& live) {
  FieldRay ray{map.apply(live.origin), {}, live.metres_per_depth};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) ray.direction[a] += map.linear[3 * a + b] * live.direction[b];
  }
  return ray;
}

} // namespace kinora::fields
