#include "clip/payloads/touched_entries.h"

#include <numeric>
#include <optional>

#include "fields/model/grid_vertex.h"

namespace kinora::clip {

namespace {

struct CellRange {
  std::uint32_t first, last; // vertices of one axis, both included
};

// For each occupancy cell of one axis, the vertices that it touches.
std::vector<CellRange> ranges_of(int resolution, int occupancy_resolution) {
  std::vector<CellRange> ranges;
  const auto n = static_cast<std::uint64_t>(resolution);
  const auto r = static_cast<std::uint64_t>(occupancy_resolution);
  for (std::uint64_t i = 0; i < r; ++i) {
    ranges.push_back(
        {static_cast<std::uint32_t>(i * n / r), static_cast<std::uint32_t>(std::min((i + 1) * n / r + 1, n))});
  }
  return ranges;
}

// Calls `visit` with the first and the last cell of each run of occupied ones along x, and with their y and z.
template <class Visit> void for_each_run(const fields::Occupancy& occupancy, const Visit& visit) {
  struct Run {
    int first, last, y, z;
  };
  std::optional<Run> run;
  fields::for_each_occupied(occupancy, [&](int x, int y, int z) {
    if (run && run->last + 1 == x && run->y == y && run->z == z) {
      run->last = x;
      return;
    }
    if (run) visit(run->first, run->last, run->y, run->z);
    run = Run{x, x, y, z};
  });
  if (run) visit(run->first, run->last, run->y, run->z);
}

} // namespace

std::vector<std::uint32_t> touched_entries(const fields::GridLevel& level, const fields::Occupancy& occupancy) {
  std::vector<std::uint32_t> touched;
  const auto widest = static_cast<std::uint64_t>(level.resolution / occupancy.resolution()) + 3;
  if (occupancy.count() > kMaxVisits / (widest * widest * widest)) {
    touched.resize(level.size);
    std::iota(touched.begin(), touched.end(), 0U);
    return touched;
  }
  std::vector<std::uint8_t> mask(level.size, 0);
  const std::vector<CellRange> ranges = ranges_of(level.resolution, occupancy.resolution());
  const auto range = [&](int cell) { return ranges[static_cast<std::size_t>(cell)]; };
  for_each_run(occupancy, [&](int first, int last, int j, int k) { // vertices of neighbours overlap
    for (std::uint32_t z = range(k).first; z <= range(k).last; ++z) {
      for (std::uint32_t y = range(j).first; y <= range(j).last; ++y) {
        for (std::uint32_t x = range(first).first; x <= range(last).last; ++x) {
          mask[fields::vertex_entry(level, x, y, z)] = 1;
        }
      }
    }
  });
  for (std::uint32_t e = 0; e < level.size; ++e) {
    if (mask[e] != 0) touched.push_back(e);
  }
  return touched;
}

std::vector<std::vector<std::uint32_t>> touched_entries(const fields::FieldConfig& config,
                                                        const fields::Occupancy& occupancy) {
  std::vector<std::vector<std::uint32_t>> touched;
  for (const fields::GridLevel& level : fields::grid_levels(config)) {
    touched.push_back(touched_entries(level, occupancy));
  }
  return touched;
}

} // namespace kinora::clip
