#include "tracking/model/node_sampling.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "core/random.h"

namespace kinora::tracking {

std::vector<SurfaceSample> downsample_surface(std::span<const SurfacePoint> surface, double cell, float min_weight) {
  constexpr int kBits = 21; // of a cell's number along an axis
  constexpr double kFarthest = (1 << (kBits - 1)) - 1;
  struct Entry {
    std::uint64_t cell;
    std::int64_t heaviest; ///< point; −1: no entry
  };
  std::vector<Entry> table(std::bit_ceil(2 * surface.size() + 1), {0, -1}); // open addressing
  std::vector<Entry> cells;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    if (surface[i].weight < min_weight) continue;
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double c = std::clamp(std::floor(surface[i].position[axis] / cell), -kFarthest, kFarthest);
      key = key << kBits | static_cast<std::uint64_t>(c + kFarthest);
    }
    std::size_t slot = mix64(key) & (table.size() - 1);
    while (table[slot].heaviest >= 0 && table[slot].cell != key) slot = (slot + 1) & (table.size() - 1);
    std::int64_t& heaviest = table[slot].heaviest;
    if (heaviest >= 0 && surface[i].weight <= surface[static_cast<std::size_t>(heaviest)].weight) continue;
    table[slot] = {key, static_cast<std::int64_t>(i)};
  }
  std::copy_if(table.begin(), table.end(), std::back_inserter(cells), [](const Entry& e) { return e.heaviest >= 0; });
  std::sort(cells.begin(), cells.end(), [](const Entry& a, const Entry& b) { return a.cell < b.cell; });
  std::vector<SurfaceSample> result;
  result.reserve(cells.size());
  for (const Entry& entry : cells) {
    const SurfacePoint& point = surface[static_cast<std::size_t>(entry.heaviest)];
    result.push_back({point.position.cast<double>(), point.normal.cast<double>()});
  }
  return result;
}

void add_nodes(std::span<const SurfaceSample> samples, double spacing, std::size_t limit,
               std::vector<Eigen::Vector3d>& nodes) {
  const motion::NearestPoints before(nodes, spacing);
  const std::size_t old = nodes.size();
  std::array<motion::NearestPoints::Neighbour, 1> found{};
  for (const SurfaceSample& sample : samples) {
    if (nodes.size() >= limit) return;
    if (before.find(sample.position, found) > 0) continue;
    const bool is_covered =
        std::any_of(nodes.begin() + static_cast<std::ptrdiff_t>(old), nodes.end(),
                    [&](const auto& n) { return (n - sample.position).squaredNorm() < spacing * spacing; });
    if (!is_covered) nodes.push_back(sample.position);
  }
}

} // namespace kinora::tracking
