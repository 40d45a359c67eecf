#include "fields/training/hidden_cells.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "core/random.h"
#include "fields/model/enclosed_cells.h"
#include "fields/network/field_batch.h"
#include "fields/network/ray_batch.h"
#include "fields/network/volume_density.h"

namespace kinora::fields {
namespace {

constexpr float kDark = 7;            // optical depth: 0.1 % of the light passes
constexpr float kMaxCell = kDark / 2; // that a cell counts for, however dense it is where it was probed
constexpr std::size_t kProbes = 2;    // of a cell
constexpr float kUnreached = std::numeric_limits<float>::infinity();

/// A number for each occupied cell.
class OccupiedCells {
public:
  explicit OccupiedCells(const Occupancy& occupancy) : side_(static_cast<std::size_t>(occupancy.resolution())) {
    const std::vector<std::uint64_t>& words = occupancy.words();
    before_.reserve(words.size());
    for (std::size_t w = 0; w < words.size(); ++w) {
      before_.push_back(static_cast<std::uint32_t>(cells_.size()));
      for (std::uint64_t bits = words[w]; bits != 0; bits &= bits - 1) {
        cells_.push_back(static_cast<std::uint32_t>(w * 64) + static_cast<std::uint32_t>(std::countr_zero(bits)));
      }
    }
    words_ = &words;
  }

  std::size_t count() const { return cells_.size(); }
  std::array<int, 3> at(std::size_t number) const {
    const std::size_t cell = cells_[number];
    return {static_cast<int>(cell % side_), static_cast<int>(cell / side_ % side_),
            static_cast<int>(cell / (side_ * side_))};
  }
  /// Of an occupied cell.
  std::size_t number_of(int x, int y, int z) const {
    const std::size_t cell =
        (static_cast<std::size_t>(z) * side_ + static_cast<std::size_t>(y)) * side_ + static_cast<std::size_t>(x);
    const std::uint64_t below = (*words_)[cell >> 6] & ((std::uint64_t{1} << (cell & 63)) - 1);
    return before_[cell >> 6] + static_cast<std::size_t>(std::popcount(below));
  }

private:
  std::size_t side_;
  std::vector<std::uint32_t> cells_;
  std::vector<std::uint32_t> before_; // cells in the words before each
  const std::vector<std::uint64_t>* words_;
};

// Of light that crosses each cell, at the thinner of some random points in it.
std::vector<float> optical_depths(const Field& field, const OccupiedCells& cells) {
  const auto per_side = static_cast<float>(field.config.occupancy_resolution);
  const auto side = static_cast<float>(field.config.box.side / field.config.density_length()) / per_side;
  const std::vector<GridLevel> levels = grid_levels(field.config);
  std::vector<float> depths(cells.count());
  parallel_for(depths.size(), 4096, [&](const Chunk& chunk) {
    std::array<std::vector<float>, 3> points;
    Random random(0x41DD, chunk.index);
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const std::array<int, 3> cell = cells.at(i);
      for (std::size_t k = 0; k < kProbes; ++k) {
        for (std::size_t a = 0; a < 3; ++a) {
          points[a].push_back((static_cast<float>(cell[a]) + random.uniform()) / per_side);
        }
      }
    }
    PointBatch batch;
    evaluate_points(field, levels, {points[0].data(), points[1].data(), points[2].data(), points[0].size()}, batch);
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      float thinnest = kMaxCell;
      for (std::size_t k = 0; k < kProbes; ++k) {
        const float raw = batch.geometry[((i - chunk.begin) * kProbes + k) * FieldConfig::kGeometry];
        thinnest = std::min(thinnest, std::exp(std::min(raw, kMaxRawDensity)) * side);
      }
      depths[i] = thinnest;
    }
  });
  return depths;
}

/// Calls `visit` with each cell that shares a corner with one.
template <typename Visit> void for_neighbours(const std::array<int, 3>& cell, Visit visit) {
  for (int z = cell[2] - 1; z <= cell[2] + 1; ++z) {
    for (int y = cell[1] - 1; y <= cell[1] + 1; ++y) {
      for (int x = cell[0] - 1; x <= cell[0] + 1; ++x) visit(x, y, z);
    }
  }
}

} // namespace

std::size_t empty_hidden_cells(Field& field) {
  const Occupancy occupancy = field.occupancy;
  const Occupancy enclosed = enclosed_cells(occupancy);
  const int side = occupancy.resolution();
  const auto is_in_box = [&](int x, int y, int z) {
    return x >= 0 && y >= 0 && z >= 0 && x < side && y < side && z < side;
  };
  const OccupiedCells cells(occupancy);
  const std::vector<float> across = optical_depths(field, cells);
  // Dijkstra's shortest paths from outside, as long as the cells that they cross are opaque.
  std::vector<float> depths(cells.count(), kUnreached); // of light on its way to each cell
  using Reached = std::pair<float, std::uint32_t>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> front;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    bool is_outermost = false;
    for_neighbours(cells.at(i), [&](int x, int y, int z) {
      is_outermost = is_outermost || !is_in_box(x, y, z) || !(occupancy.at(x, y, z) || enclosed.at(x, y, z));
    });
    if (!is_outermost) continue;
    depths[i] = 0;
    front.emplace(0.0F, static_cast<std::uint32_t>(i));
  }
  while (!front.empty()) {
    const auto [depth, i] = front.top();
    front.pop();
    if (depth > depths[i]) continue; // reached by a shorter way
    const float beyond = depth + across[i];
    if (beyond >= kDark) continue;
    for_neighbours(cells.at(i), [&](int x, int y, int z) {
      if (!is_in_box(x, y, z) || !occupancy.at(x, y, z)) return;
      const std::size_t neighbour = cells.number_of(x, y, z);
      if (beyond >= depths[neighbour]) return;
      depths[neighbour] = beyond;
      front.emplace(beyond, static_cast<std::uint32_t>(neighbour));
    });
  }
  std::size_t emptied = 0;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (depths[i] < kDark) continue;
    const auto [x, y, z] = cells.at(i);
    field.occupancy.set(x, y, z, false);
    ++emptied;
  }
  return emptied;
}

} // namespace kinora::fields
