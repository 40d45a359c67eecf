#include "fields/model/field.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::fields {

const char* name_of(Geometry geometry) { return geometry == Geometry::kDensity ? "density" : "signed_distance"; }

void FieldConfig::validate(const std::string& source) const {
  const auto require = [&source](bool valid, const std::string& what) {
    if (!valid) throw Error(ErrorCode::kCorruptInput, fmt::format("{}: a field's {} is out of range", source, what));
  };
  constexpr double kFarthest = 1e7; // metres
  require(box.origin.allFinite() && box.origin.cwiseAbs().maxCoeff() < kFarthest, "box origin");
  require(std::isfinite(box.side) && box.side > 1e-6 && box.side < kFarthest, "box side");
  require(levels >= 2 && levels <= FieldLimits::kMaxLevels && levels % 2 == 0, "number of levels");
  require(log2_table_size >= 4 && log2_table_size <= FieldLimits::kMaxLog2TableSize, "table size");
  require(coarsest_resolution >= 1 && finest_resolution >= coarsest_resolution &&
              finest_resolution <= FieldLimits::kMaxResolution,
          "grid resolution");
  require(occupancy_resolution >= 64 && occupancy_resolution <= FieldLimits::kMaxOccupancyResolution &&
              occupancy_resolution % 64 == 0,
          "occupancy resolution");
}

std::size_t Occupancy::count() const {
  std::size_t total = 0;
  for (const std::uint64_t word : bits_) total += static_cast<std::size_t>(std::popcount(word));
  return total;
}

Occupancy coarsened(const Occupancy& occupancy, int factor) {
  Occupancy coarse(occupancy.resolution() / factor);
  std::vector<int> block(static_cast<std::size_t>(occupancy.resolution()));
  for (std::size_t i = 0; i < block.size(); ++i) block[i] = static_cast<int>(i) / factor;
  const auto block_of = [&](int i) { return block[static_cast<std::size_t>(i)]; };
  for_each_occupied(occupancy, [&](int x, int y, int z) { coarse.set(block_of(x), block_of(y), block_of(z)); });
  return coarse;
}

std::vector<GridLevel> grid_levels(const FieldConfig& config) {
  std::vector<GridLevel> levels;
  const double growth = config.levels > 1
                            ? std::pow(static_cast<double>(config.finest_resolution) / config.coarsest_resolution,
                                       1.0 / (config.levels - 1))
                            : 1.0;
  const std::uint64_t limit = std::uint64_t{1} << config.log2_table_size;
  std::uint32_t offset = 0;
  for (int l = 0; l < config.levels; ++l) {
    const int resolution = static_cast<int>(std::lround(config.coarsest_resolution * std::pow(growth, l)));
    const std::uint64_t side = static_cast<std::uint64_t>(resolution) + 1;
    const bool hashed = side * side * side > limit;
    const auto size = static_cast<std::uint32_t>(hashed ? limit : side * side * side);
    levels.push_back({resolution, offset, size, hashed});
    offset += size;
  }
  return levels;
}

std::size_t grid_entry_count(const FieldConfig& config) {
  const std::vector<GridLevel> levels = grid_levels(config);
  return levels.empty() ? 0 : levels.back().offset + levels.back().size;
}

Field::Field(const FieldConfig& field_config)
    : config(field_config), table(grid_entry_count(field_config) * FieldConfig::kFeatures),
      density_net(static_cast<std::size_t>(field_config.encoding_width() * FieldConfig::kHidden +
                                           FieldConfig::kHidden * FieldConfig::kGeometry)),
      color_net(FieldConfig::kGeometry * FieldConfig::kColorHidden +
                FieldConfig::kColorHidden * FieldConfig::kColorHidden +
                FieldConfig::kColorHidden * FieldConfig::kColorOutputs),
      occupancy(field_config.occupancy_resolution) {}

std::vector<GridLevel> stored_levels(const Field& field) {
  std::vector<GridLevel> levels = grid_levels(field.config);
  const auto is_zero = [&](const GridLevel& level) {
    const float* first = field.table.data() + std::size_t{level.offset} * FieldConfig::kFeatures;
    return std::all_of(first, first + std::size_t{level.size} * FieldConfig::kFeatures, [](float v) { return v == 0; });
  };
  while (levels.size() > 1 && is_zero(levels.back())) levels.pop_back();
  return levels;
}

} // namespace kinora::fields
