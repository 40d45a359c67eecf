#include "fields/model/field.h"

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
  const auto r = static_cast<std::size_t>(occupancy.resolution());
  const auto block = static_cast<std::size_t>(factor);
  for (std::size_t w = 0; w < occupancy.words().size(); ++w) {
    for (std::uint64_t bits = occupancy.words()[w]; bits != 0; bits &= bits - 1) {
      const std::size_t cell = w * 64 + static_cast<std::size_t>(std::countr_zero(bits));
      coarse.set(static_cast<int>(cell % r / block), static_cast<int>(cell / r % r / block),
                 static_cast<int>(cell / (r * r) / block));
    }
  }
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

} // namespace kinora::fields
