#include "fields/occupancy.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "core/parallel.h"

namespace kinora::fields {
namespace {

using Words = std::vector<std::uint64_t>;

// One dilation by a cell along x (within rows of `words` words), then along y and z.
class Dilation {
public:
  explicit Dilation(int resolution)
      : side_(static_cast<std::size_t>(resolution)), words_(side_ / 64), scratch_(words_ * side_ * side_) {}

  void run(Words& bits) {
    rows(bits);
    axis(bits, words_, side_);
    axis(bits, words_ * side_, side_);
  }

private:
  void rows(Words& bits) const {
    for (std::size_t row = 0; row < side_ * side_; ++row) {
      std::uint64_t* w = bits.data() + row * words_;
      std::uint64_t before = 0;
      for (std::size_t i = 0; i < words_; ++i) {
        const std::uint64_t word = w[i];
        const std::uint64_t after = i + 1 < words_ ? w[i + 1] : 0;
        w[i] = word | (word << 1) | (word >> 1) | (before >> 63) | (after << 63);
        before = word;
      }
    }
  }
  // Neighbours are `stride` words apart; every line has `count` of them.
  void axis(Words& bits, std::size_t stride, std::size_t count) {
    scratch_ = bits;
    const std::size_t block = stride * count;
    for (std::size_t begin = 0; begin < bits.size(); begin += block) {
      for (std::size_t i = begin; i < begin + block; ++i) {
        if (i >= begin + stride) bits[i] |= scratch_[i - stride];
        if (i + stride < begin + block) bits[i] |= scratch_[i + stride];
      }
    }
  }

  std::size_t side_;
  std::size_t words_;
  Words scratch_;
};

float safe_inverse(float value) {
  constexpr float kSmallest = 1e-12F;
  return 1.0F / (std::abs(value) < kSmallest ? std::copysign(kSmallest, value) : value);
}

int cell_of(float coordinate, int resolution) {
  return std::clamp(static_cast<int>(std::clamp(coordinate, 0.0F, static_cast<float>(resolution))), 0, resolution - 1);
}

} // namespace

DistanceField::DistanceField(const Occupancy& occupancy) : resolution_(occupancy.resolution()) {
  const std::size_t cells = static_cast<std::size_t>(resolution_) * resolution_ * resolution_;
  distance_.assign(cells, static_cast<std::uint8_t>(kFarthest));
  Words reached(occupancy.words().size(), 0);
  Words current = occupancy.words();
  Dilation dilation(resolution_);
  for (int distance = 0; distance < kFarthest; ++distance) {
    for (std::size_t w = 0; w < current.size(); ++w) {
      for (std::uint64_t fresh = current[w] & ~reached[w]; fresh != 0; fresh &= fresh - 1) {
        distance_[w * 64 + static_cast<std::size_t>(std::countr_zero(fresh))] = static_cast<std::uint8_t>(distance);
      }
    }
    reached = current;
    dilation.run(current);
  }
}

OccupiedIntervals::OccupiedIntervals(const DistanceField& distances, const FieldRay& ray, float near_depth,
                                     float far_depth)
    : distances_(&distances), depth_(near_depth), end_(far_depth) {
  const float resolution = static_cast<float>(distances.resolution());
  for (std::size_t a = 0; a < 3; ++a) {
    origin_[a] = ray.origin[a] * resolution;
    direction_[a] = ray.direction[a] * resolution;
    inverse_[a] = safe_inverse(direction_[a]);
    const float t0 = -origin_[a] * inverse_[a];
    const float t1 = (resolution - origin_[a]) * inverse_[a];
    depth_ = std::max(depth_, std::min(t0, t1));
    end_ = std::min(end_, std::max(t0, t1));
  }
  if (depth_ >= end_) return;
  for (std::size_t a = 0; a < 3; ++a) {
    cell_[a] = cell_of(origin_[a] + depth_ * direction_[a], distances.resolution());
  }
}

int OccupiedIntervals::advance() {
  const int resolution = distances_->resolution();
  const int distance = distances_->at(cell_[0], cell_[1], cell_[2]);
  const int reach = std::max(distance - 1, 0); // empty cells on each side that may be leapt over
  std::size_t axis = 3;                        // whose wall the ray meets first
  float exit = end_;
  for (std::size_t a = 0; a < 3; ++a) {
    if (direction_[a] == 0) continue;
    const float wall = static_cast<float>(direction_[a] > 0 ? cell_[a] + 1 + reach : cell_[a] - reach);
    const float depth = (wall - origin_[a]) * inverse_[a];
    if (depth < exit) {
      exit = depth;
      axis = a;
    }
  }
  depth_ = std::max(depth_, exit);
  if (axis == 3) {
    depth_ = end_;
    return distance;
  }
  // Cells are counted, not derived from depth_ alone: rounding may lay a point on the wrong side of a wall, and a walk
  // that trusts it creeps along that wall. So the axis that is crossed moves by whole cells, and no other turns back.
  for (std::size_t a = 0; a < 3; ++a) {
    const int direction = direction_[a] > 0 ? 1 : -1;
    if (a == axis) {
      cell_[a] += direction * (reach + 1);
    } else if (direction_[a] != 0) {
      const int there = cell_of(origin_[a] + depth_ * direction_[a], resolution);
      cell_[a] += direction * std::clamp((there - cell_[a]) * direction, 0, reach);
    }
  }
  if (cell_[axis] < 0 || cell_[axis] >= resolution) depth_ = end_;
  return distance;
}

bool OccupiedIntervals::next(Interval& interval) {
  bool inside = false;
  while (depth_ < end_) {
    const float begin = depth_;
    if (advance() == 0) {
      if (!inside) interval.begin = begin;
      inside = true;
      interval.end = depth_;
    } else if (inside) {
      return true;
    }
  }
  return inside;
}

Interval in_box(const FieldRay& ray, Interval interval) {
  for (std::size_t a = 0; a < 3; ++a) {
    const float inverse = safe_inverse(ray.direction[a]);
    const float t0 = -ray.origin[a] * inverse;
    const float t1 = (1 - ray.origin[a]) * inverse;
    interval.begin = std::max(interval.begin, std::min(t0, t1));
    interval.end = std::min(interval.end, std::max(t0, t1));
  }
  return interval;
}

bool is_occupied(const Occupancy& occupancy, const std::array<float, 3>& position) {
  std::array<int, 3> cell{};
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(position[a] >= 0 && position[a] < 1)) return false;
    cell[a] = cell_of(position[a] * static_cast<float>(occupancy.resolution()), occupancy.resolution());
  }
  return occupancy.at(cell[0], cell[1], cell[2]);
}

void mark_occupied(Occupancy& occupancy, const FieldRay& ray, const Interval& interval) {
  const auto r = static_cast<std::size_t>(occupancy.resolution());
  const auto cells = static_cast<float>(r);
  std::array<float, 3> origin{};    // cells
  std::array<float, 3> direction{}; // cells per metre of depth
  float fastest = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    origin[a] = ray.origin[a] * cells;
    direction[a] = ray.direction[a] * cells;
    fastest = std::max(fastest, std::abs(direction[a]));
  }
  const float step = 0.5F / std::max(fastest, 1e-12F);
  const int steps = static_cast<int>(std::min((interval.end - interval.begin) / step, 4.0F * cells)) + 1;
  std::size_t last = r * r * r; // two steps often end in one cell
  for (int i = 0; i <= steps; ++i) {
    const float depth = std::min(interval.begin + step * static_cast<float>(i), interval.end);
    const float x = origin[0] + depth * direction[0];
    const float y = origin[1] + depth * direction[1];
    const float z = origin[2] + depth * direction[2];
    if (!(x >= 0 && y >= 0 && z >= 0 && x < cells && y < cells && z < cells)) continue;
    const std::size_t bit =
        (static_cast<std::size_t>(z) * r + static_cast<std::size_t>(y)) * r + static_cast<std::size_t>(x);
    if (bit == last) continue;
    last = bit;
    const std::uint64_t mask = std::uint64_t{1} << (bit & 63);
    std::atomic_ref<std::uint64_t> word(occupancy.words()[bit >> 6]);
    if ((word.load(std::memory_order_relaxed) & mask) == 0) word.fetch_or(mask, std::memory_order_relaxed);
  }
}

} // namespace kinora::fields
