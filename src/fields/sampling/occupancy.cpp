#include "fields/sampling/occupancy.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace kinora::fields {
namespace {

float safe_inverse(float value) {
  constexpr float kSmallest = 1e-12F;
  return 1.0F / (std::abs(value) < kSmallest ? std::copysign(kSmallest, value) : value);
}

} // namespace

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
