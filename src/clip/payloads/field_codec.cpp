#include "clip/payloads/field_codec.h"

#include <cmath>

#include <fmt/format.h>

#include "clip/coding/level_quantiser.h"
#include "clip/payloads/field_syntax.h"
#include "clip/payloads/touched_entries.h"
#include "container/little_endian.h"
#include "core/error.h"

namespace kinora::clip {

using container::get;
using container::get_double;
using container::put;
using fields::Field;
using fields::FieldConfig;
using fields::Geometry;
using fields::GridLevel;

namespace {

// 1 and 2 had no vectors among the features; 3 and 4 are still read.
constexpr std::uint8_t kZstdDensityVersion = 3;
constexpr std::uint8_t kVersion = 5;
constexpr std::size_t kFixedHeaderBytes = 56;
constexpr std::size_t kZstdSizesAt = 48; // versions 3 and 4
constexpr std::size_t kGeometryAt = 48;  // version 5
constexpr std::size_t kBytesPerLevel = 4;
constexpr std::size_t kMatrices = 5;
constexpr std::size_t kFeatures = FieldConfig::kFeatures;
constexpr Rounding kTableRounding{2, 0.6}; // as good in novel views as finer steps rounded to the nearest
constexpr Rounding kNetRounding{32};

struct Header {
  std::uint8_t version = kVersion;
  FieldConfig config;
  float sharpness = 0;                 // of a field of signed distances
  std::vector<int> exponents;          // one per level, then (not in versions 3 and 4) one per matrix
  std::vector<std::size_t> part_bytes; // of what follows the header, in its order
  std::size_t bytes = 0;               // of the header
};

std::uint16_t half_bits(float value) {
  constexpr float kLargestHalf = 65504;
  if (!std::isfinite(value)) {
    throw Error(ErrorCode::kFailure,
                "a field holds parameters that are not finite; it cannot be stored, train it anew");
  }
  return Eigen::numext::bit_cast<std::uint16_t>(Eigen::half(std::clamp(value, -kLargestHalf, kLargestHalf)));
}

void put_header(Bytes& out, const Header& header) {
  const FieldConfig& c = header.config;
  const bool has_distances = c.geometry == Geometry::kSignedDistance;
  constexpr float kMax = fields::FieldLimits::kMaxSharpness;
  put(out, kVersion);
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
  put(out, std::uint16_t{0});
  const std::vector<GridLevel> levels = fields::grid_levels(c);
  for (std::size_t l = 0; l < levels.size(); ++l) {
    put(out, static_cast<std::uint16_t>(levels[l].resolution));
    put(out, static_cast<std::int8_t>(header.exponents[l]));
    put(out, std::uint8_t{0});
  }
  for (const std::size_t bytes : header.part_bytes) put(out, static_cast<std::uint32_t>(bytes));
}

[[noreturn]] void corrupt(const std::string& location, const std::string& why) {
  throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", location, why));
}

float get_half(std::span<const std::byte> bytes, std::size_t at, const std::string& location) {
  const auto value = static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(get<std::uint16_t>(bytes, at)));
  if (!std::isfinite(value)) corrupt(location, "a field holds parameters that are not finite");
  return value;
}

int checked_exponent(int exponent, const std::string& location) {
  if (exponent < kMinExponent || exponent > kMaxExponent) corrupt(location, "a field's scale is out of range");
  return exponent;
}

// Exponents of levels and matrices, and where the parts behind the header are.
void get_parts(std::span<const std::byte> payload, Header& header, const std::string& location) {
  const bool is_coded = header.version == kVersion;
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
}

Header get_header(std::span<const std::byte> payload, const std::string& location) {
  if (payload.size() < kFixedHeaderBytes) corrupt(location, "a field is too short for its header");
  Header header;
  header.version = get<std::uint8_t>(payload, 0);
  if (header.version < kZstdDensityVersion || header.version > kVersion) {
    corrupt(location,
            fmt::format("a field has version {}; this Kinora reads versions {} to {}, encode its capture again",
                        header.version, kZstdDensityVersion, kVersion));
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
  const auto geometry = header.version == kVersion ? get<std::uint8_t>(payload, kGeometryAt)
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

std::int16_t unzigzag(unsigned z) { return static_cast<std::int16_t>((z >> 1) ^ (0U - (z & 1))); }

void check_shape(const Field& field) {
  const Field expected(field.config);
  if (field.table.size() != expected.table.size() || field.density_net.size() != expected.density_net.size() ||
      field.color_net.size() != expected.color_net.size() ||
      field.occupancy.resolution() != field.config.occupancy_resolution) {
    throw Error(ErrorCode::kFailure, "a field's parameters do not fit its configuration; it cannot be stored");
  }
}

void get_halves(std::span<const std::byte> bytes, std::span<float> values, const std::string& location) {
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = get_half(bytes, 2 * i, location);
}

// The weights of both nets, matrix by matrix: density (2), then colour (3).
std::array<std::span<float>, kMatrices> matrices_of(Field& field) {
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

template <class Code> Bytes coded(const Code& code) {
  RangeEncoder encoder;
  code(encoder);
  return encoder.finish();
}

template <class Code> void decoded(std::span<const std::byte> part, const std::string& location, const Code& code) {
  RangeDecoder decoder(part, location);
  code(decoder);
  decoder.finish();
}

void decode_parts(std::span<const std::byte> payload, const Header& header, Field& field, const std::string& location) {
  std::size_t at = header.bytes;
  const auto part = [&](std::size_t p) {
    const std::span<const std::byte> bytes = payload.subspan(at, header.part_bytes[p]);
    at += header.part_bytes[p];
    return bytes;
  };
  decoded(part(0), location, [&](RangeDecoder& decoder) {
    const fields::Occupancy unknown(header.config.occupancy_resolution);
    code_occupancy(decoder, unknown, field.occupancy);
  });
  const std::vector<GridLevel> levels = fields::grid_levels(header.config);
  decoded(part(1), location, [&](RangeDecoder& decoder) {
    std::size_t m = levels.size();
    for (const std::span<float> matrix : matrices_of(field)) {
      std::vector<std::int16_t> values(matrix.size());
      code_matrix(decoder, values, location);
      for (std::size_t i = 0; i < values.size(); ++i) matrix[i] = dequantise(values[i], header.exponents[m]);
      ++m;
    }
  });
  const std::vector<std::vector<std::uint32_t>> touched = touched_entries(header.config, field.occupancy);
  for (std::size_t l = 0; l < levels.size(); ++l) {
    std::vector<std::int16_t> values(touched[l].size() * kFeatures);
    decoded(part(2 + l), location, [&](RangeDecoder& decoder) { code_level(decoder, values, location); });
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::size_t entry = std::size_t{levels[l].offset} + touched[l][i / kFeatures];
      field.table[entry * kFeatures + i % kFeatures] = dequantise(values[i], header.exponents[l]);
    }
  }
}

// Versions 3 and 4: occupancy and parameters as Zstandard frames.
void decode_zstd_parts(std::span<const std::byte> payload, const Header& header, Field& field,
                       const std::string& location) {
  const std::span<const std::byte> stored_parameters = payload.last(header.part_bytes[1]);
  const std::span<const std::byte> stored_occupancy = payload.subspan(header.bytes, header.part_bytes[0]);
  std::vector<std::uint64_t>& words = field.occupancy.words();
  const Bytes occupancy = decompress(stored_occupancy, words.size() * 8, location);
  for (std::size_t w = 0; w < words.size(); ++w) words[w] = get<std::uint64_t>(occupancy, 8 * w);

  const std::vector<std::vector<std::uint32_t>> touched = touched_entries(header.config, field.occupancy);
  std::size_t plane_bytes = 0;
  for (const std::vector<std::uint32_t>& level : touched) plane_bytes += level.size() * kFeatures;
  const std::size_t net_values = field.density_net.size() + field.color_net.size();
  const Bytes parameters = decompress(stored_parameters, 2 * (plane_bytes + net_values), location);

  const std::vector<GridLevel> levels = fields::grid_levels(header.config);
  std::size_t at = 0;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    for (std::size_t f = 0; f < kFeatures; ++f) {
      for (const std::uint32_t entry : touched[l]) {
        const unsigned z = get<std::uint8_t>(parameters, at) | unsigned{get<std::uint8_t>(parameters, plane_bytes + at)}
                                                                   << 8;
        field.table[(std::size_t{levels[l].offset} + entry) * kFeatures + f] =
            dequantise(unzigzag(z), header.exponents[l]);
        ++at;
      }
    }
  }
  const std::span<const std::byte> nets = std::span(parameters).subspan(2 * plane_bytes);
  get_halves(nets, field.density_net, location);
  get_halves(nets.subspan(2 * field.density_net.size()), field.color_net, location);
}

} // namespace

Bytes encode_field(const Field& field) {
  field.config.validate("a clip to be written");
  check_shape(field);
  Header header;
  header.config = field.config;
  header.sharpness = field.sharpness;
  const std::string writer = "a clip to be written";
  const std::vector<GridLevel> levels = fields::grid_levels(field.config);
  const std::vector<std::vector<std::uint32_t>> touched = touched_entries(field.config, field.occupancy);
  std::vector<Bytes> level_parts;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    std::vector<float> values;
    values.reserve(touched[l].size() * kFeatures);
    for (const std::uint32_t entry : touched[l]) {
      const float* const first = field.table.data() + (std::size_t{levels[l].offset} + entry) * kFeatures;
      values.insert(values.end(), first, first + kFeatures);
    }
    QuantisedLevel level = quantise(values, kTableRounding);
    header.exponents.push_back(level.exponent);
    level_parts.push_back(coded([&](RangeEncoder& encoder) { code_level(encoder, level.values, writer); }));
  }
  Field nets = field;
  std::vector<Bytes> parts;
  parts.push_back(coded([&](RangeEncoder& encoder) {
    fields::Occupancy coded_cells(field.config.occupancy_resolution);
    code_occupancy(encoder, field.occupancy, coded_cells);
  }));
  parts.push_back(coded([&](RangeEncoder& encoder) {
    for (const std::span<float> matrix : matrices_of(nets)) {
      QuantisedLevel quantised_matrix = quantise(matrix, kNetRounding);
      header.exponents.push_back(quantised_matrix.exponent);
      code_matrix(encoder, quantised_matrix.values, writer);
    }
  }));
  parts.insert(parts.end(), level_parts.begin(), level_parts.end());
  for (const Bytes& part : parts) header.part_bytes.push_back(part.size());
  Bytes out;
  put_header(out, header);
  for (const Bytes& part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}

Field decode_field(std::span<const std::byte> payload, const std::string& location, AllocationBudget& budget) {
  const Header header = get_header(payload, location);
  budget.take(decoding_memory(header.config), location);
  Field field(header.config);
  field.sharpness = header.sharpness;
  if (header.version == kVersion) {
    decode_parts(payload, header, field, location);
  } else {
    decode_zstd_parts(payload, header, field, location);
  }
  return field;
}

std::uint64_t decoding_memory(const FieldConfig& config) {
  const auto r = static_cast<std::uint64_t>(config.occupancy_resolution);
  const std::uint64_t table_bytes = fields::grid_entry_count(config) * kFeatures * sizeof(float);
  return 2 * table_bytes + r * r * r / 4; // twice: table and occupancy, and what is needed on the way to them
}

Field quantised(const Field& field) {
  const Bytes payload = encode_field(field);
  AllocationBudget budget(field.table.size() * sizeof(float));
  return decode_field(payload, "a field that was just encoded", budget);
}

} // namespace kinora::clip
