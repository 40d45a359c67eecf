#include "clip/payloads/touched_entries.h"

#include <bit>
#include <numeric>

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

template <class Visit> void for_each_occupied(const fields::Occupancy& occupancy, const Visit& visit) {
  const auto r = static_cast<std::size_t>(occupancy.resolution());
  for (std::size_t w = 0; w < occupancy.words().size(); ++w) {
    for (std::uint64_t left = occupancy.words()[w]; left != 0; left &= left - 1) {
      const std::size_t cell = w * 64 + static_cast<std::size_t>(std::countr_zero(left));
      visit(cell % r, cell / r % r, cell / (r * r));
    }
  }
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
  std::vector<bool> mask(level.size, false);
  const std::vector<CellRange> ranges = ranges_of(level.resolution, occupancy.resolution());
  for_each_occupied(occupancy, [&](std::size_t i, std::size_t j, std::size_t k) {
    for (std::uint32_t z = ranges[k].first; z <= ranges[k].last; ++z) {
      for (std::uint32_t y = ranges[j].first; y <= ranges[j].last; ++y) {
        for (std::uint32_t x = ranges[i].first; x <= ranges[i].last; ++x) {
          mask[fields::vertex_entry(level, x, y, z)] = true;
        }
      }
    }
  });
  for (std::uint32_t e = 0; e < level.size; ++e) {
    if (mask[e]) touched.push_back(e);
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
