#include "fields/rendering/density_bricks.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/parallel.h"
#include "fields/network/field_batch.h"
#include "fields/network/ray_batch.h"
#include "fields/network/volume_density.h"

namespace kinora::fields {
namespace {

constexpr int kSide = DensityBricks::kSide;
constexpr int kLevels = DensityBricks::kLevels;
constexpr std::size_t kSamples = static_cast<std::size_t>(kLevels) * kLevels * kLevels;
static_assert(DensityBricks::kLowest + 255 * DensityBricks::kStep == kMaxRawDensity);

/// Bricks that have an occupied cell within reach of their samples, in order of their index.
std::vector<std::array<int, 3>> bricks_of(const Occupancy& occupancy, int resolution) {
  const int per_side = (resolution + kSide - 1) / kSide;
  const double lattice_per_cell = static_cast<double>(resolution) / occupancy.resolution();
  std::vector<std::uint8_t> needed(static_cast<std::size_t>(per_side) * per_side * per_side, 0);
  const auto range = [&](int cell) {
    const int low = static_cast<int>(std::floor((cell * lattice_per_cell - 1) / kSide));
    const int high = static_cast<int>(std::floor(((cell + 1) * lattice_per_cell + 1) / kSide));
    return std::array<int, 2>{std::max(low, 0), std::min(high, per_side - 1)};
  };
  std::vector<std::array<int, 2>> ranges;
  ranges.reserve(static_cast<std::size_t>(occupancy.resolution()));
  for (int cell = 0; cell < occupancy.resolution(); ++cell) ranges.push_back(range(cell));
  for_each_occupied(occupancy, [&](int x, int y, int z) {
    const auto [x0, x1] = ranges[static_cast<std::size_t>(x)];
    const auto [y0, y1] = ranges[static_cast<std::size_t>(y)];
    const auto [z0, z1] = ranges[static_cast<std::size_t>(z)];
    for (int k = z0; k <= z1; ++k) {
      for (int j = y0; j <= y1; ++j) {
        const std::size_t row = static_cast<std::size_t>(k * per_side + j) * static_cast<std::size_t>(per_side);
        for (int i = x0; i <= x1; ++i) needed[row + static_cast<std::size_t>(i)] = 1;
      }
    }
  });
  std::vector<std::array<int, 3>> coordinates;
  for (int z = 0; z < per_side; ++z) {
    for (int y = 0; y < per_side; ++y) {
      for (int x = 0; x < per_side; ++x) {
        const int index = (z * per_side + y) * per_side + x;
        if (needed[static_cast<std::size_t>(index)] != 0) coordinates.push_back({x, y, z});
      }
    }
  }
  return coordinates;
}

std::uint8_t quantised(float raw) {
  const float level = (raw - DensityBricks::kLowest) / DensityBricks::kStep;
  return static_cast<std::uint8_t>(std::floor(std::clamp(level, 0.0F, 255.0F) + 0.5F));
}

using BrickBytes = std::array<std::uint8_t, kSamples>; // x, then y, then z fastest to slowest

void write_pairs(const BrickBytes& bytes, std::uint16_t* pairs) {
  for (int z = 0; z < kLevels; ++z) {
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kLevels; ++x) {
        const std::uint8_t* b = bytes.data() + (z * kLevels + y) * kLevels + x;
        *pairs++ = static_cast<std::uint16_t>(b[0] | b[kLevels] << 8);
      }
    }
  }
}

/// Samples one brick after the other; buffers are kept.
class BrickSampler {
public:
  BrickSampler(const Field& field, std::span<const GridLevel> levels, int resolution)
      : field_(field), levels_(levels), resolution_(resolution) {}

  /// Fills bytes() for the brick; false if it is as good as empty.
  bool sample(const std::array<int, 3>& coordinates) {
    bytes_.fill(0);
    const std::array<AxisSamples, 3> axes{samples_along(coordinates[0]), samples_along(coordinates[1]),
                                          samples_along(coordinates[2])};
    find_reached(axes);
    std::size_t count = 0;
    for (std::size_t row = 0; row < reached_.size(); ++row) {
      for (unsigned bits = reached_[row]; bits != 0; bits &= bits - 1, ++count) {
        const auto x = static_cast<std::size_t>(std::countr_zero(bits));
        x_[count] = axes[0].position[x];
        y_[count] = axes[1].position[row % kLevels];
        z_[count] = axes[2].position[row / kLevels];
        at_[count] = static_cast<std::uint16_t>(row * kLevels + x);
      }
    }
    evaluate_points(field_, levels_, {x_.data(), y_.data(), z_.data(), count}, points_);
    std::uint8_t max_byte = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint8_t byte = quantised(points_.geometry[k * FieldConfig::kGeometry]);
      bytes_[at_[k]] = byte;
      max_byte = std::max(max_byte, byte);
    }
    return max_byte >= DensityBricks::kVisible;
  }

  const BrickBytes& bytes() const { return bytes_; }

private:
  using Reached = std::uint16_t; // a bit for each sample along x
  static_assert(kLevels <= 16);

  /// The samples of a brick along one axis, and the cells of the occupancy within half a lattice step of each.
  struct AxisSamples {
    std::array<float, kLevels> position{}; // relative to the field's box
    std::array<int, kLevels> low{}, high{};

    int first() const { return low.front(); }
    int count() const { return std::max(high.back() - low.front() + 1, 0); }
  };
  AxisSamples samples_along(int brick) const {
    const auto cells = static_cast<float>(field_.occupancy.resolution());
    const float reach = 0.5F / static_cast<float>(resolution_);
    AxisSamples samples;
    for (int i = 0; i < kLevels; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const float position = static_cast<float>(brick * kSide + i) / static_cast<float>(resolution_);
      samples.position[at] = position;
      samples.low[at] = std::max(static_cast<int>(std::floor((position - reach) * cells)), 0);
      samples.high[at] =
          std::min(static_cast<int>(std::floor((position + reach) * cells)), field_.occupancy.resolution() - 1);
    }
    return samples;
  }

  // Which samples have occupied space within half a lattice step: one axis after the other, all along x at once.
  void find_reached(const std::array<AxisSamples, 3>& axes) {
    const auto& [x, y, z] = axes;
    const auto rows = static_cast<std::size_t>(y.count());
    const auto layers = static_cast<std::size_t>(z.count());
    of_cells_.assign(layers * rows, 0);
    for (std::size_t k = 0; k < layers; ++k) {
      for (std::size_t j = 0; j < rows; ++j) {
        of_cells_[k * rows + j] = reached_along(x, y.first() + static_cast<int>(j), z.first() + static_cast<int>(k));
      }
    }
    of_rows_.assign(layers * kLevels, 0);
    for (std::size_t k = 0; k < layers; ++k) {
      for (std::size_t j = 0; j < kLevels; ++j) {
        for (int cell = y.low[j]; cell <= y.high[j]; ++cell) {
          of_rows_[k * kLevels + j] |= of_cells_[k * rows + static_cast<std::size_t>(cell - y.first())];
        }
      }
    }
    reached_.fill(0);
    for (std::size_t k = 0; k < kLevels; ++k) {
      for (int cell = z.low[k]; cell <= z.high[k]; ++cell) {
        const std::size_t layer = static_cast<std::size_t>(cell - z.first()) * kLevels;
        for (std::size_t j = 0; j < kLevels; ++j) reached_[k * kLevels + j] |= of_rows_[layer + j];
      }
    }
  }
  // Of one row of cells along x: a bit for each sample, which has a few cells about it.
  Reached reached_along(const AxisSamples& x, int row, int layer) const {
    const auto n = static_cast<std::size_t>(field_.occupancy.resolution());
    const std::size_t begin = (static_cast<std::size_t>(layer) * n + static_cast<std::size_t>(row)) * n;
    if (x.count() <= 64 && cells_from(begin + static_cast<std::size_t>(x.first()), x.count()) == 0) return 0;
    unsigned reached = 0;
    for (std::size_t i = 0; i < kLevels; ++i) {
      if (x.high[i] < x.low[i]) continue;
      const std::size_t first = begin + static_cast<std::size_t>(x.low[i]);
      if (cells_from(first, x.high[i] - x.low[i] + 1) != 0) reached |= 1U << i;
    }
    return static_cast<Reached>(reached);
  }
  // A bit for each of up to 64 cells from the occupancy's `first` on.
  std::uint64_t cells_from(std::size_t first, int count) const {
    const std::vector<std::uint64_t>& words = field_.occupancy.words();
    std::uint64_t cells = words[first / 64] >> (first % 64);
    if (first % 64 != 0 && first / 64 + 1 < words.size()) cells |= words[first / 64 + 1] << (64 - first % 64);
    return count < 64 ? cells & ((std::uint64_t{1} << count) - 1) : cells;
  }

  const Field& field_;
  std::span<const GridLevel> levels_;
  int resolution_;
  std::array<float, kSamples> x_{}, y_{}, z_{}; // of the points
  std::array<std::uint16_t, kSamples> at_{};    // the sample that each is
  PointBatch points_;
  BrickBytes bytes_{};
  std::array<Reached, std::size_t{kLevels} * kLevels> reached_{}; // by z, then y
  std::vector<Reached> of_cells_, of_rows_;                       // reached from rows of cells; by cell along z
};

} // namespace

DensityBricks::DensityBricks(const Field& field, BrickDetail detail) : resolution_(field.config.finest_resolution) {
  constexpr int kFine = 512;
  while (4 * resolution_ <= kFine) resolution_ *= 2; // what nets bend within the cells of small fields
  // Large fields are trained with samples as far apart as the sensor's noise asks for, some cells.
  for (int limit = kFine; resolution_ > limit; limit = kMaxResolution) resolution_ = (resolution_ + 1) / 2;
  if (detail == BrickDetail::kHalf) resolution_ = (resolution_ + 1) / 2;
  const std::vector<std::array<int, 3>> candidates = bricks_of(field.occupancy, resolution_);
  constexpr std::size_t kChunk = 64;
  struct Part {
    std::vector<std::array<int, 3>> coordinates;
    std::vector<BrickBytes> bytes; // little more than half of the pairs
  };
  const std::vector<GridLevel> levels = stored_levels(field);
  std::vector<Part> parts(chunk_count(candidates.size(), kChunk));
  parallel_for(candidates.size(), kChunk, [&](const Chunk& chunk) {
    BrickSampler sampler(field, levels, resolution_);
    Part& part = parts[chunk.index];
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      if (!sampler.sample(candidates[i])) continue;
      part.coordinates.push_back(candidates[i]);
      part.bytes.push_back(sampler.bytes());
    }
  });
  std::size_t count = 0;
  for (const Part& part : parts) count += part.coordinates.size();
  coordinates_.reserve(count);
  pairs_.resize(count * kPairs);
  std::uint16_t* pairs = pairs_.data();
  for (Part& part : parts) {
    coordinates_.insert(coordinates_.end(), part.coordinates.begin(), part.coordinates.end());
    for (const BrickBytes& bytes : part.bytes) {
      write_pairs(bytes, pairs);
      pairs += kPairs;
    }
    part = {};
  }
  const auto per_side = static_cast<std::size_t>(bricks_per_side());
  index_.assign(per_side * per_side * per_side, -1);
  for (std::size_t i = 0; i < coordinates_.size(); ++i) {
    const auto [x, y, z] = coordinates_[i];
    index_[(static_cast<std::size_t>(z) * per_side + static_cast<std::size_t>(y)) * per_side +
           static_cast<std::size_t>(x)] = static_cast<std::int32_t>(i);
  }
}

int DensityBricks::brick_at(int x, int y, int z) const {
  const int n = bricks_per_side();
  if (x < 0 || y < 0 || z < 0 || x >= n || y >= n || z >= n) return -1;
  const int index = (z * n + y) * n + x;
  return index_[static_cast<std::size_t>(index)];
}

std::uint8_t DensityBricks::largest(std::size_t brick, const std::array<int, 3>& low, int side) const {
  const std::uint16_t* pairs = pairs_.data() + brick * kPairs;
  int max_byte = 0;
  for (int z = low[2]; z <= low[2] + side; ++z) {
    for (int y = low[1]; y < low[1] + side; ++y) {
      for (int x = low[0]; x <= low[0] + side; ++x) {
        const int pair = pairs[(z * kSide + y) * kLevels + x];
        max_byte = std::max({max_byte, pair & 255, pair >> 8});
      }
    }
  }
  return static_cast<std::uint8_t>(max_byte);
}

float DensityBricks::raw_density(const std::array<float, 3>& at) const {
  std::array<int, 3> low{};
  std::array<float, 3> fraction{};
  for (std::size_t a = 0; a < 3; ++a) {
    const float floor = std::floor(std::clamp(at[a], -1.0F, static_cast<float>(resolution_)));
    low[a] = static_cast<int>(floor);
    fraction[a] = at[a] - floor;
  }
  const int brick =
      low[0] < 0 || low[1] < 0 || low[2] < 0 ? -1 : brick_at(low[0] / kSide, low[1] / kSide, low[2] / kSide);
  if (brick < 0) return kLowest;
  const std::uint16_t* pairs = pairs_.data() + static_cast<std::size_t>(brick) * kPairs;
  float sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = (corner >> 1) & 1, dz = corner >> 2;
    const int pair = ((low[2] % kSide + dz) * kSide + low[1] % kSide) * kLevels + low[0] % kSide + dx;
    const int byte = pairs[pair] >> (8 * dy) & 255;
    sum += static_cast<float>(byte) * (dx != 0 ? fraction[0] : 1 - fraction[0]) *
           (dy != 0 ? fraction[1] : 1 - fraction[1]) * (dz != 0 ? fraction[2] : 1 - fraction[2]);
  }
  return kLowest + kStep * sum;
}

} // namespace kinora::fields
