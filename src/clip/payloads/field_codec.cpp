#include "clip/payloads/field_codec.h"

#include <cmath>

#include <fmt/format.h>

#include "clip/coding/level_quantiser.h"
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

constexpr std::uint8_t kDensityVersion = 3; // 1 and 2 had no vectors among the features
constexpr std::uint8_t kSignedDistanceVersion = 4;
constexpr std::size_t kFixedHeaderBytes = 56;
constexpr std::size_t kBytesPerLevel = 4;
constexpr std::size_t kFeatures = FieldConfig::kFeatures;

struct Header {
  FieldConfig config;
  float sharpness = 0;             // of a field of signed distances
  std::vector<int> exponents;      // one per level
  std::size_t occupancy_bytes = 0; // compressed
  std::size_t parameter_bytes = 0; // compressed
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
  put(out, has_distances ? kSignedDistanceVersion : kDensityVersion);
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
  put(out, static_cast<std::uint32_t>(header.occupancy_bytes));
  put(out, static_cast<std::uint32_t>(header.parameter_bytes));
  const std::vector<GridLevel> levels = fields::grid_levels(c);
  for (std::size_t l = 0; l < levels.size(); ++l) {
    put(out, static_cast<std::uint16_t>(levels[l].resolution));
    put(out, static_cast<std::int8_t>(header.exponents[l]));
    put(out, std::uint8_t{0});
  }
}

[[noreturn]] void corrupt(const std::string& location, const std::string& why) {
  throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", location, why));
}

float get_half(std::span<const std::byte> bytes, std::size_t at, const std::string& location) {
  const auto value = static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(get<std::uint16_t>(bytes, at)));
  if (!std::isfinite(value)) corrupt(location, "a field holds parameters that are not finite");
  return value;
}

Header get_header(std::span<const std::byte> payload, const std::string& location) {
  if (payload.size() < kFixedHeaderBytes) corrupt(location, "a field is too short for its header");
  const auto version = get<std::uint8_t>(payload, 0);
  if (version != kDensityVersion && version != kSignedDistanceVersion) {
    corrupt(location,
            fmt::format("a field has version {}; this Kinora reads versions {} and {}, encode its capture again",
                        version, kDensityVersion, kSignedDistanceVersion));
  }
  if (get<std::uint8_t>(payload, 3) != FieldConfig::kFeatures ||
      get<std::uint8_t>(payload, 10) != FieldConfig::kHidden ||
      get<std::uint8_t>(payload, 11) != FieldConfig::kGeometry ||
      get<std::uint8_t>(payload, 12) != FieldConfig::kColorHidden ||
      get<std::uint8_t>(payload, 13) != FieldConfig::kColorOutputs) {
    corrupt(location, "a field has networks of a shape that this Kinora does not know");
  }
  Header header;
  FieldConfig& c = header.config;
  c.levels = get<std::uint8_t>(payload, 1);
  c.log2_table_size = get<std::uint8_t>(payload, 2);
  c.coarsest_resolution = get<std::uint16_t>(payload, 4);
  c.finest_resolution = get<std::uint16_t>(payload, 6);
  c.occupancy_resolution = get<std::uint16_t>(payload, 8);
  for (std::size_t a = 0; a < 3; ++a) c.box.origin[static_cast<Eigen::Index>(a)] = get_double(payload, 16 + 8 * a);
  c.box.side = get_double(payload, 40);
  c.validate(location);
  if (version == kSignedDistanceVersion) {
    c.geometry = Geometry::kSignedDistance;
    header.sharpness = get_half(payload, 14, location);
    if (std::abs(header.sharpness) > fields::FieldLimits::kMaxSharpness)
      corrupt(location, "a field's sharpness is out of range");
  }
  header.occupancy_bytes = get<std::uint32_t>(payload, 48);
  header.parameter_bytes = get<std::uint32_t>(payload, 52);

  const std::size_t header_bytes = kFixedHeaderBytes + kBytesPerLevel * static_cast<std::size_t>(c.levels);
  if (payload.size() != header_bytes + header.occupancy_bytes + header.parameter_bytes) {
    corrupt(location, "a field's parts do not add up to its size");
  }
  std::size_t at = kFixedHeaderBytes;
  for (const GridLevel& level : fields::grid_levels(c)) {
    if (get<std::uint16_t>(payload, at) != level.resolution)
      corrupt(location, "a field's levels do not grow geometrically");
    header.exponents.push_back(get<std::int8_t>(payload, at + 2));
    if (header.exponents.back() < kMinExponent || header.exponents.back() > kMaxExponent) {
      corrupt(location, "a field's scale is out of range");
    }
    at += kBytesPerLevel;
  }
  return header;
}

// Small magnitudes of either sign become small numbers, so that their high bytes are zero.
std::uint16_t zigzag(std::int16_t v) { return static_cast<std::uint16_t>((v * 2) ^ (v >> 15)); }
std::int16_t unzigzag(unsigned z) { return static_cast<std::int16_t>((z >> 1) ^ (0U - (z & 1))); }

void check_shape(const Field& field) {
  const Field expected(field.config);
  if (field.table.size() != expected.table.size() || field.density_net.size() != expected.density_net.size() ||
      field.color_net.size() != expected.color_net.size() ||
      field.occupancy.resolution() != field.config.occupancy_resolution) {
    throw Error(ErrorCode::kFailure, "a field's parameters do not fit its configuration; it cannot be stored");
  }
}

// Level by level and feature by feature, all low bytes first, then all high bytes.
void put_planes(Bytes& out, const std::vector<QuantisedLevel>& levels) {
  for (const int shift : {0, 8}) {
    for (const QuantisedLevel& level : levels) {
      for (std::size_t f = 0; f < kFeatures; ++f) {
        for (std::size_t i = f; i < level.values.size(); i += kFeatures) {
          out.push_back(static_cast<std::byte>(zigzag(level.values[i]) >> shift & 0xFF));
        }
      }
    }
  }
}

void put_halves(Bytes& out, std::span<const float> values) {
  for (const float value : values) put(out, half_bits(value));
}

void get_halves(std::span<const std::byte> bytes, std::span<float> values, const std::string& location) {
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = get_half(bytes, 2 * i, location);
}

Bytes occupancy_bytes_of(const fields::Occupancy& occupancy) {
  Bytes out;
  out.reserve(occupancy.words().size() * 8);
  for (const std::uint64_t word : occupancy.words()) put(out, word);
  return out;
}

} // namespace

Bytes encode_field(const Field& field) {
  field.config.validate("a clip to be written");
  check_shape(field);
  Header header{field.config, field.sharpness, {}, 0, 0};
  const std::vector<GridLevel> levels = fields::grid_levels(field.config);
  const std::vector<std::vector<std::uint32_t>> touched = touched_entries(field.config, field.occupancy);
  std::vector<QuantisedLevel> quantised_levels;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    std::vector<float> values;
    values.reserve(touched[l].size() * kFeatures);
    for (const std::uint32_t entry : touched[l]) {
      const float* const first = field.table.data() + (std::size_t{levels[l].offset} + entry) * kFeatures;
      values.insert(values.end(), first, first + kFeatures);
    }
    quantised_levels.push_back(quantise(values));
    header.exponents.push_back(quantised_levels.back().exponent);
  }
  Bytes parameters;
  put_planes(parameters, quantised_levels);
  put_halves(parameters, field.density_net);
  put_halves(parameters, field.color_net);

  const Bytes stored_occupancy = compress(occupancy_bytes_of(field.occupancy));
  const Bytes stored_parameters = compress(parameters);
  header.occupancy_bytes = stored_occupancy.size();
  header.parameter_bytes = stored_parameters.size();
  Bytes out;
  put_header(out, header);
  out.insert(out.end(), stored_occupancy.begin(), stored_occupancy.end());
  out.insert(out.end(), stored_parameters.begin(), stored_parameters.end());
  return out;
}

Field decode_field(std::span<const std::byte> payload, const std::string& location, AllocationBudget& budget) {
  const Header header = get_header(payload, location);
  budget.take(decoding_memory(header.config), location);
  Field field(header.config);
  field.sharpness = header.sharpness;

  const std::span<const std::byte> stored_parameters = payload.last(header.parameter_bytes);
  const std::span<const std::byte> stored_occupancy =
      payload.subspan(payload.size() - header.parameter_bytes - header.occupancy_bytes, header.occupancy_bytes);
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
