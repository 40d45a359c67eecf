#include "clip/payloads/field_codec.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "clip/coding/level_quantiser.h"
#include "clip/payloads/field_header.h"
#include "clip/payloads/field_syntax.h"
#include "clip/payloads/touched_entries.h"
#include "container/little_endian.h"
#include "core/error.h"

namespace kinora::clip {

using container::get;
using fields::Field;
using fields::FieldConfig;
using fields::GridLevel;

namespace {

constexpr std::size_t kFeatures = FieldConfig::kFeatures;
constexpr std::size_t kFinerLevelHeaderBytes = 4;
constexpr int kCoarseSteps = 4; // in the root mean square of a level: bits pay where a level is small
constexpr int kFineSteps = 1;
constexpr double kUpFrom = 0.55;
constexpr Rounding kNetRounding{32};

[[noreturn]] void corrupt(const std::string& location, const std::string& why) {
  throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", location, why));
}

// Levels of the coarser half alone give a picture already.
std::size_t coarse_levels(const FieldConfig& config) { return static_cast<std::size_t>(config.levels) / 2; }

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

// What differences are to: the parameters of a base, in steps of the new field; without one, zero.
class BaseIntegers {
public:
  explicit BaseIntegers(const Field* base) : base_(base) {}

  std::int32_t of_entry(std::size_t parameter, int exponent) const {
    return base_ == nullptr ? 0 : in_steps(base_->table[parameter], exponent);
  }
  std::int32_t of_weight(std::size_t matrix, std::size_t parameter, int exponent) const {
    return base_ == nullptr ? 0 : in_steps(matrices_of(*base_)[matrix][parameter], exponent);
  }

private:
  static std::int32_t in_steps(float value, int exponent) {
    const double steps = std::nearbyint(std::ldexp(static_cast<double>(value), -exponent));
    return static_cast<std::int32_t>(std::clamp(steps, double{INT16_MIN}, double{INT16_MAX}));
  }

  const Field* base_;
};

// An integer as its difference to that of the base; it is kept where the difference would not fit.
std::int16_t difference(std::int16_t value, std::int32_t base) {
  return static_cast<std::int16_t>(std::clamp(value - base, std::int32_t{INT16_MIN}, std::int32_t{INT16_MAX}));
}

std::int16_t sum(std::int16_t difference, std::int32_t base, const std::string& location) {
  const std::int32_t value = difference + base;
  if (value < INT16_MIN || value > INT16_MAX) corrupt(location, "a field's parameter is out of range");
  return static_cast<std::int16_t>(value);
}

// Cells become those in which two fields of one shape differ, and such become cells again; they stay if there is but
// one field.
void change_cells(fields::Occupancy& cells, const Field* base) {
  for (std::size_t w = 0; base != nullptr && w < cells.words().size(); ++w)
    cells.words()[w] ^= base->occupancy.words()[w];
}

// Without a base, damage leaves the field as it was.
void decode_level(std::span<const std::byte> part, int exponent, const GridLevel& level, const BaseIntegers& before,
                  Field& field, const std::string& location) {
  const std::vector<std::uint32_t> touched = touched_entries(level, field.occupancy);
  std::vector<std::int16_t> values(touched.size() * kFeatures);
  decoded(part, location, [&](RangeDecoder& decoder) { code_level(decoder, values, location); });
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t parameter = (std::size_t{level.offset} + touched[i / kFeatures]) * kFeatures + i % kFeatures;
    field.table[parameter] = dequantise(sum(values[i], before.of_entry(parameter, exponent), location), exponent);
  }
}

void decode_parts(std::span<const std::byte> payload, const FieldHeader& header, const Field* base, Field& field,
                  const std::string& location) {
  std::size_t at = header.bytes;
  const auto part = [&](std::size_t p) {
    const std::span<const std::byte> bytes = payload.subspan(at, header.part_bytes[p]);
    at += header.part_bytes[p];
    return bytes;
  };
  const BaseIntegers before(base);
  decoded(part(0), location, [&](RangeDecoder& decoder) {
    const fields::Occupancy unknown(header.config.occupancy_resolution);
    code_occupancy(decoder, unknown, field.occupancy);
  });
  change_cells(field.occupancy, base);
  const std::vector<GridLevel> levels = fields::grid_levels(header.config);
  decoded(part(1), location, [&](RangeDecoder& decoder) {
    for (std::size_t m = 0; m < kMatrices; ++m) {
      const std::span<float> matrix = matrices_of(field)[m];
      const int exponent = header.exponents[levels.size() + m];
      std::vector<std::int16_t> values(matrix.size());
      code_matrix(decoder, values, location);
      for (std::size_t i = 0; i < values.size(); ++i)
        matrix[i] = dequantise(sum(values[i], before.of_weight(m, i, exponent), location), exponent);
    }
  });
  for (std::size_t l = 0; l < static_cast<std::size_t>(header.levels_here); ++l)
    decode_level(part(2 + l), header.exponents[l], levels[l], before, field, location);
}

// Versions 3 and 4: occupancy and parameters as Zstandard frames.
void decode_zstd_parts(std::span<const std::byte> payload, const FieldHeader& header, Field& field,
                       const std::string& location) {
  const std::span<const std::byte> stored_parameters = payload.last(header.part_bytes[1]);
  const std::span<const std::byte> stored_occupancy = payload.subspan(header.bytes, header.part_bytes[0]);
  std::vector<std::uint64_t>& words = field.occupancy.words();
  {
    const Bytes occupancy = decompress(stored_occupancy, words.size() * 8, location);
    for (std::size_t w = 0; w < words.size(); ++w) words[w] = get<std::uint64_t>(occupancy, 8 * w);
  }
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

struct CodedField {
  FieldHeader header;
  std::vector<Bytes> parts; // occupancy, networks, levels
};

CodedField code(const Field& field, const Field* base, const FieldRounding& rounding) {
  field.config.validate("a clip to be written");
  check_shape(field);
  FieldHeader header;
  header.version = base == nullptr ? kFieldVersion : kFieldDifferenceVersion;
  header.config = field.config;
  header.sharpness = field.sharpness;
  const BaseIntegers before(base);
  const std::string writer = "a clip to be written";
  const std::vector<GridLevel> levels = fields::grid_levels(field.config);
  const std::vector<std::vector<std::uint32_t>> touched = touched_entries(field.config, field.occupancy);
  std::vector<Bytes> level_parts;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    std::vector<float> values;
    std::vector<std::size_t> parameters;
    values.reserve(touched[l].size() * kFeatures);
    parameters.reserve(touched[l].size() * kFeatures);
    for (const std::uint32_t entry : touched[l]) {
      for (std::size_t f = 0; f < kFeatures; ++f) {
        parameters.push_back((std::size_t{levels[l].offset} + entry) * kFeatures + f);
        values.push_back(field.table[parameters.back()]);
      }
    }
    QuantisedLevel level = quantise(values, rounding.at(l));
    for (std::size_t i = 0; i < values.size(); ++i)
      level.values[i] = difference(level.values[i], before.of_entry(parameters[i], level.exponent));
    header.exponents.push_back(level.exponent);
    level_parts.push_back(coded([&](RangeEncoder& encoder) { code_level(encoder, level.values, writer); }));
  }
  std::vector<Bytes> parts;
  parts.push_back(coded([&](RangeEncoder& encoder) {
    fields::Occupancy coded_cells(field.config.occupancy_resolution);
    fields::Occupancy changed = field.occupancy;
    change_cells(changed, base);
    code_occupancy(encoder, changed, coded_cells);
  }));
  parts.push_back(coded([&](RangeEncoder& encoder) {
    for (std::size_t m = 0; m < kMatrices; ++m) {
      QuantisedLevel matrix = quantise(matrices_of(field)[m], kNetRounding);
      for (std::size_t i = 0; i < matrix.values.size(); ++i)
        matrix.values[i] = difference(matrix.values[i], before.of_weight(m, i, matrix.exponent));
      header.exponents.push_back(matrix.exponent);
      code_matrix(encoder, matrix.values, writer);
    }
  }));
  parts.insert(parts.end(), level_parts.begin(), level_parts.end());
  for (const Bytes& part : parts) header.part_bytes.push_back(part.size());
  return {std::move(header), std::move(parts)};
}

Bytes payload_of(const FieldHeader& header, std::span<const Bytes> parts) {
  Bytes out;
  put_header(out, header);
  for (const Bytes& part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}

Bytes encode(const Field& field, const Field* base) {
  const CodedField coded = code(field, base, usual_rounding(field.config));
  return payload_of(coded.header, coded.parts);
}

Field decode(std::span<const std::byte> payload, const Field* base, const std::string& location,
             AllocationBudget& budget) {
  const FieldHeader header = get_header(payload, location);
  const bool is_difference = header.version == kFieldDifferenceVersion;
  if (header.levels_here < header.config.levels) corrupt(location, "a field lacks its finer levels");
  if (is_difference != (base != nullptr) || (is_difference && header.config != base->config))
    corrupt(location, "a field is stored as the difference to one that is not there");
  budget.take(decoding_memory(header.config), location);
  Field field(header.config);
  field.sharpness = header.sharpness;
  if (header.version >= kFieldVersion) {
    decode_parts(payload, header, base, field, location);
  } else {
    decode_zstd_parts(payload, header, field, location);
  }
  return field;
}

} // namespace

Bytes encode_field(const Field& field) { return encode(field, nullptr); }

FieldRounding usual_rounding(const FieldConfig& config) {
  FieldRounding rounding(static_cast<std::size_t>(config.levels), {kFineSteps, kUpFrom});
  std::fill_n(rounding.begin(), coarse_levels(config), Rounding{kCoarseSteps, kUpFrom});
  return rounding;
}

RoundedField rounded(const Field& field, const FieldRounding& rounding) {
  const CodedField coded = code(field, nullptr, rounding);
  AllocationBudget budget(field.table.size() * sizeof(float));
  return {decode_field(payload_of(coded.header, coded.parts), "a field that was just encoded", budget),
          {coded.header.part_bytes.begin() + 2, coded.header.part_bytes.end()}};
}

std::vector<Bytes> encode_field_coarse_first(const Field& field, const FieldRounding& rounding) {
  CodedField coded = code(field, nullptr, rounding);
  const std::size_t here = coarse_levels(field.config);
  std::vector<Bytes> payloads(1);
  for (std::size_t l = here; l < static_cast<std::size_t>(field.config.levels); ++l) {
    Bytes& finer = payloads.emplace_back();
    container::put(finer, kFinerLevelVersion);
    container::put(finer, static_cast<std::uint8_t>(l));
    container::put(finer, static_cast<std::int8_t>(std::exchange(coded.header.exponents[l], 0)));
    container::put(finer, std::uint8_t{0});
    finer.insert(finer.end(), coded.parts[2 + l].begin(), coded.parts[2 + l].end());
    coded.header.part_bytes[2 + l] = 0;
  }
  coded.header.version = kCoarseFieldVersion;
  coded.header.levels_here = static_cast<int>(here);
  payloads.front() = payload_of(coded.header, std::span(coded.parts).first(2 + here));
  return payloads;
}

void FieldDecoder::take(std::span<const std::byte> payload, const std::string& location, AllocationBudget& budget) {
  if (payload.empty() || get<std::uint8_t>(payload, 0) != kFinerLevelVersion) {
    begin(payload, location, budget);
    return;
  }
  if (!field_) corrupt(location, "a level of a field comes before the field");
  if (payload.size() < kFinerLevelHeaderBytes || get<std::uint8_t>(payload, 1) != levels_ ||
      levels_ == field_->config.levels)
    corrupt(location, "a level of a field is not the one that follows");
  const int exponent = checked_exponent(get<std::int8_t>(payload, 2), location);
  const auto level = static_cast<std::size_t>(levels_);
  decode_level(payload.subspan(kFinerLevelHeaderBytes), exponent, fields::grid_levels(field_->config)[level],
               BaseIntegers(nullptr), *field_, location);
  ++levels_;
}

void FieldDecoder::begin(std::span<const std::byte> payload, const std::string& location, AllocationBudget& budget) {
  if (field_) corrupt(location, "a field comes twice");
  const FieldHeader header = get_header(payload, location);
  if (header.version != kCoarseFieldVersion) {
    field_ = decode_field(payload, location, budget);
    levels_ = field_->config.levels;
    return;
  }
  budget.take(decoding_memory(header.config), location);
  Field field(header.config);
  field.sharpness = header.sharpness;
  decode_parts(payload, header, nullptr, field, location);
  field_ = std::move(field);
  levels_ = header.levels_here;
}

Bytes encode_field_difference(const Field& field, const Field& base) {
  check_shape(base);
  if (field.config != base.config)
    throw Error(ErrorCode::kFailure, "fields of different shapes have no difference that could be stored");
  return encode(field, &base);
}

Field decode_field(std::span<const std::byte> payload, const std::string& location, AllocationBudget& budget) {
  return decode(payload, nullptr, location, budget);
}

Field decode_field_difference(std::span<const std::byte> payload, const Field& base, const std::string& location,
                              AllocationBudget& budget) {
  return decode(payload, &base, location, budget);
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
