#include "fields/training/table_growth.h"

#include <algorithm>

#include "fields/model/grid_vertex.h"

namespace kinora::fields {
namespace {

constexpr std::size_t kF = FieldConfig::kFeatures;

void copy_rows(const float* from, std::size_t count, float* to) { std::copy_n(from, count * kF, to); }

// Calls visit(entry, the entry of a level of the same vertices with half as many) for a level that is hashed no more.
template <class Visit> void for_each_vertex(const GridLevel& dense, const GridLevel& hashed, const Visit& visit) {
  const auto n = static_cast<std::uint32_t>(dense.resolution) + 1;
  for (std::uint32_t z = 0; z < n; ++z) {
    for (std::uint32_t y = 0; y < n; ++y) {
      for (std::uint32_t x = 0; x < n; ++x) {
        visit(vertex_entry(dense, x, y, z), vertex_entry(hashed, x, y, z));
      }
    }
  }
}

} // namespace

FieldConfig with_doubled_tables(const FieldConfig& config) {
  FieldConfig doubled = config;
  ++doubled.log2_table_size;
  return doubled;
}

bool can_double_tables(const FieldConfig& config) {
  const std::vector<GridLevel> levels = grid_levels(config);
  return config.log2_table_size < FieldLimits::kMaxLog2TableSize &&
         std::any_of(levels.begin(), levels.end(), [](const GridLevel& level) { return level.hashed; });
}

LargeBuffer<float> with_doubled_rows(const FieldConfig& config, const LargeBuffer<float>& rows) {
  const FieldConfig doubled = with_doubled_tables(config);
  const std::vector<GridLevel> before = grid_levels(config);
  const std::vector<GridLevel> after = grid_levels(doubled);
  LargeBuffer<float> larger(grid_entry_count(doubled) * kF);
  for (std::size_t l = 0; l < before.size(); ++l) {
    const float* from = rows.data() + before[l].offset * kF;
    float* to = larger.data() + after[l].offset * kF;
    if (after[l].hashed) { // the hash has one more bit: both of its values
      copy_rows(from, before[l].size, to);
      copy_rows(from, before[l].size, to + before[l].size * kF);
    } else if (before[l].hashed) {
      for_each_vertex(after[l], before[l], [&](std::size_t entry, std::size_t shared) {
        copy_rows(from + shared * kF, 1, to + entry * kF);
      });
    } else {
      copy_rows(from, before[l].size, to);
    }
  }
  return larger;
}

Field with_doubled_tables(const Field& field) {
  Field larger = field;
  larger.config = with_doubled_tables(field.config);
  larger.table = with_doubled_rows(field.config, field.table);
  return larger;
}

} // namespace kinora::fields
