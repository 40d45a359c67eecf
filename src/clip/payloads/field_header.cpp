#include "clip/payloads/field_header.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "clip/coding/level_quantiser.h"
#include "container/little_endian.h"
#include "core/error.h"

namespace kinora::clip {

using container::get;
using container::get_double;
using container::put;
using fields::FieldConfig;
using fields::Geometry;
using fields::GridLevel;

namespace {

constexpr std::size_t kFixedHeaderBytes = 56;
constexpr std::size_t kZstdSizesAt = 48;  // versions 3 and 4
constexpr std::size_t kGeometryAt = 48;   // version 5
constexpr std::size_t kLevelsHereAt = 54; // version 7
constexpr std::size_t kBytesPerLevel = 4;

std::uint16_t half_bits(float value) {
  constexpr float kLargestHalf = 65504;
  if (!std::isfinite(value)) {
    throw Error(ErrorCode::kFailure,
                "a field holds parameters that are not finite; it cannot be stored, train it anew");
  }
  return Eigen::numext::bit_cast<std::uint16_t>(Eigen::half(std::clamp(value, -kLargestHalf, kLargestHalf)));
}

[[noreturn]] void corrupt(const std::string& location, const std::string& why) {
  throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", location, why));
}

// Exponents of levels and matrices, and where the parts behind the header are.
void get_parts(std::span<const std::byte> payload, FieldHeader& header, const std::string& location) {
  const bool is_coded = header.version >= kFieldVersion;
  const auto levels = static_cast<std::size_t>(header.config.levels);
  const std::size_t parts = is_coded ? 2 + levels : 2;
  const std::size_t sizes_at = is_coded ? kFixedHeaderBytes + kBytesPerLevel * levels : kZstdSizesAt;
  header.bytes = kFixedHeaderBytes + kBytesPerLevel * levels + (is_coded ? 4 * parts : 0);
  if (payload.size() < header.bytes) corrupt(location, "a field is too short for its header");
  std::size_t at = kFixedHeaderBytes;
  for (const GridLevel& level : fields::grid_levels(header.config)) {
    if (get<std::uint16_t>(payload, at) != level.resolution)
      corrupt(location, "a field's levels do not grow geometrically");
    header.exponents.push_back(checked_exponent(get<std::int8_t>(payload, at + 2), location));
    at += kBytesPerLevel;
  }
  for (std::size_t m = 0; is_coded && m < kMatrices; ++m) {
    header.exponents.push_back(checked_exponent(get<std::int8_t>(payload, kGeometryAt + 1 + m), location));
  }
  std::uint64_t total = header.bytes;
  for (std::size_t p = 0; p < parts; ++p) {
    header.part_bytes.push_back(get<std::uint32_t>(payload, sizes_at + 4 * p));
    total += header.part_bytes.back();
  }
  if (payload.size() != total) corrupt(location, "a field's parts do not add up to its size");
  header.levels_here = header.config.levels;
  if (header.version != kCoarseFieldVersion) return;
  header.levels_here = get<std::uint16_t>(payload, kLevelsHereAt);
  if (header.levels_here < 1 || header.levels_here > header.config.levels)
    corrupt(location, "a field says that it has a number of levels that it cannot have");
  for (std::size_t p = 2 + static_cast<std::size_t>(header.levels_here); p < parts; ++p) {
    if (header.part_bytes[p] != 0) corrupt(location, "a field has levels that it says are elsewhere");
  }
}

} // namespace

int checked_exponent(int exponent, const std::string& location) {
  if (exponent < kMinExponent || exponent > kMaxExponent) corrupt(location, "a field's scale is out of range");
  return exponent;
}

float get_half(std::span<const std::byte> bytes, std::size_t at, const std::string& location) {
  const auto value = static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(get<std::uint16_t>(bytes, at)));
  if (!std::isfinite(value)) corrupt(location, "a field holds parameters that are not finite");
  return value;
}

void put_header(Bytes& out, const FieldHeader& header) {
  const FieldConfig& c = header.config;
  const bool has_distances = c.geometry == Geometry::kSignedDistance;
  constexpr float kMax = fields::FieldLimits::kMaxSharpness;
  put(out, header.version);
  put(out, static_cast<std::uint8_t>(c.levels));
  put(out, static_cast<std::uint8_t>(c.log2_table_size));
  put(out, static_cast<std::uint8_t>(FieldConfig::kFeatures));
  put(out, static_cast<std::uint16_t>(c.coarsest_resolution));
  put(out, static_cast<std::uint16_t>(c.finest_resolution));
  put(out, static_cast<std::uint16_t>(c.occupancy_resolution));
  put(out, static_cast<std::uint8_t>(FieldConfig::kHidden));
  put(out, static_cast<std::uint8_t>(FieldConfig::kGeometry));
  put(out, static_cast<std::uint8_t>(FieldConfig::kColorHidden));
  put(out, static_cast<std::uint8_t>(FieldConfig::kColorOutputs));
  put(out, has_distances ? half_bits(std::clamp(header.sharpness, -kMax, kMax)) : std::uint16_t{0});
  for (int a = 0; a < 3; ++a) put(out, c.box.origin[a]);
  put(out, c.box.side);
  put(out, static_cast<std::uint8_t>(has_distances ? 1 : 0));
  for (std::size_t m = 0; m < kMatrices; ++m) {
    put(out, static_cast<std::int8_t>(header.exponents[static_cast<std::size_t>(c.levels) + m]));
  }
  put(out, static_cast<std::uint16_t>(header.version == kCoarseFieldVersion ? header.levels_here : 0));
  const std::vector<GridLevel> levels = fields::grid_levels(c);
  for (std::size_t l = 0; l < levels.size(); ++l) {
    put(out, static_cast<std::uint16_t>(levels[l].resolution));
    put(out, static_cast<std::int8_t>(header.exponents[l]));
    put(out, std::uint8_t{0});
  }
  for (const std::size_t bytes : header.part_bytes) put(out, static_cast<std::uint32_t>(bytes));
}

FieldHeader get_header(std::span<const std::byte> payload, const std::string& location) {
  if (payload.size() < kFixedHeaderBytes) corrupt(location, "a field is too short for its header");
  FieldHeader header;
  header.version = get<std::uint8_t>(payload, 0);
  if (header.version < kZstdDensityVersion || header.version > kCoarseFieldVersion) {
    corrupt(location,
            fmt::format("a field has version {}; this Kinora reads versions {} to {}, encode its capture again",
                        header.version, kZstdDensityVersion, kFinerLevelVersion));
  }
  if (get<std::uint8_t>(payload, 3) != FieldConfig::kFeatures ||
      get<std::uint8_t>(payload, 10) != FieldConfig::kHidden ||
      get<std::uint8_t>(payload, 11) != FieldConfig::kGeometry ||
      get<std::uint8_t>(payload, 12) != FieldConfig::kColorHidden ||
      get<std::uint8_t>(payload, 13) != FieldConfig::kColorOutputs) {
    corrupt(location, "a field has networks of a shape that this Kinora does not know");
  }
  FieldConfig& c = header.config;
  c.levels = get<std::uint8_t>(payload, 1);
  c.log2_table_size = get<std::uint8_t>(payload, 2);
  c.coarsest_resolution = get<std::uint16_t>(payload, 4);
  c.finest_resolution = get<std::uint16_t>(payload, 6);
  c.occupancy_resolution = get<std::uint16_t>(payload, 8);
  for (std::size_t a = 0; a < 3; ++a) c.box.origin[static_cast<Eigen::Index>(a)] = get_double(payload, 16 + 8 * a);
  c.box.side = get_double(payload, 40);
  c.validate(location);
  const auto geometry = header.version >= kFieldVersion
                            ? get<std::uint8_t>(payload, kGeometryAt)
                            : static_cast<std::uint8_t>(header.version - kZstdDensityVersion);
  if (geometry > 1) corrupt(location, "a field has a geometry that this Kinora does not know");
  if (geometry == 1) {
    c.geometry = Geometry::kSignedDistance;
    header.sharpness = get_half(payload, 14, location);
    if (std::abs(header.sharpness) > fields::FieldLimits::kMaxSharpness)
      corrupt(location, "a field's sharpness is out of range");
  }
  get_parts(payload, header, location);
  return header;
}

std::array<std::span<float>, kMatrices> matrices_of(fields::Field& field) {
  constexpr std::size_t kHidden = FieldConfig::kHidden;
  constexpr std::size_t kGeometry = FieldConfig::kGeometry;
  constexpr std::size_t kColorHidden = FieldConfig::kColorHidden;
  const std::span density(field.density_net);
  const std::span color(field.color_net);
  const std::size_t first = density.size() - kHidden * kGeometry;
  return {density.first(first), density.subspan(first), color.first(kGeometry * kColorHidden),
          color.subspan(kGeometry * kColorHidden, kColorHidden * kColorHidden),
          color.subspan((kGeometry + kColorHidden) * kColorHidden)};
}

std::array<std::span<const float>, kMatrices> matrices_of(const fields::Field& field) {
  const auto matrices = matrices_of(const_cast<fields::Field&>(field)); // only looked at
  return {matrices[0], matrices[1], matrices[2], matrices[3], matrices[4]};
}

} // namespace kinora::clip
