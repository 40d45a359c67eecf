// A field as the bytes of S_KINORA/FIELD payloads, and back. docs/container.md specifies them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "clip/coding/allocation_budget.h"
#include "clip/coding/level_quantiser.h"
#include "clip/coding/zstd_codec.h"
#include "fields/model/field.h"

namespace kinora::clip {

/// Stored are the occupancy exactly, and the table entries that it touches (touched_entries.h) and both networks as
/// integers times one power of two for each level and matrix (level_quantiser.h), arithmetically coded
/// (field_syntax.h), coarse levels first; the sharpness as a 16-bit float. The same field gives the same bytes.
/// Thread-safe. Throws Error(kFailure) if parameters are not finite, or their number does not fit the configuration.
Bytes encode_field(const fields::Field& field);

/// Entries that no occupied cell touches come back as zero. encode_field(decode_field(b)) = b for every b that
/// encode_field wrote. Safe for untrusted input; allocates at most what `budget` gives. Thread-safe.
/// Throws Error(kCorruptInput) naming `location`.
fields::Field decode_field(std::span<const std::byte> payload, const std::string& location, AllocationBudget& budget);

/// One entry for each level, coarse to fine.
using FieldRounding = std::vector<Rounding>;

/// What encode_field takes.
FieldRounding usual_rounding(const fields::FieldConfig& config);

/// The same bits as several payloads, as a file has them: the first is a field that can be drawn, of the coarser half
/// of the levels; each that follows adds the next level. FieldDecoder reads them. Throws as encode_field; `rounding`
/// must have an entry for each level.
std::vector<Bytes> encode_field_coarse_first(const fields::Field& field, const FieldRounding& rounding);

/// What rounding costs: the field as a reader will see it, and the bytes of each of its levels.
struct RoundedField {
  fields::Field field;
  std::vector<std::size_t> level_bytes;
};
RoundedField rounded(const fields::Field& field, const FieldRounding& rounding);

/// A field out of its payloads, in their order: encode_field_coarse_first's, or the one of encode_field. Levels that
/// have not come are zero. For one thread at a time.
class FieldDecoder {
public:
  /// Throws Error(kCorruptInput) naming `location`; then the field is as it was. Safe for untrusted input.
  void take(std::span<const std::byte> payload, const std::string& location, AllocationBudget& budget);

  bool is_whole() const { return field_ && levels_ == field_->config.levels; }
  const std::optional<fields::Field>& field() const { return field_; }
  std::optional<fields::Field> taken_field() && { return std::move(field_); }

private:
  void begin(std::span<const std::byte> payload, const std::string& location, AllocationBudget& budget);

  std::optional<fields::Field> field_;
  int levels_ = 0; // that have come
};

/// The same as differences to the integers of `base`, a field of the same configuration, as it was decoded: small if
/// training has changed little since. Throws Error(kFailure) also if the configurations differ.
Bytes encode_field_difference(const fields::Field& field, const fields::Field& base);

/// What decode_field(encode_field(field)) would give. Throws Error(kCorruptInput) naming `location`, also if the base
/// has another configuration.
fields::Field decode_field_difference(std::span<const std::byte> payload, const fields::Field& base,
                                      const std::string& location, AllocationBudget& budget);

/// Bytes that decode_field takes from its budget.
std::uint64_t decoding_memory(const fields::FieldConfig& config);

/// The field as a reader of the file will see it: decode_field(encode_field(field)).
fields::Field quantised(const fields::Field& field);

} // namespace kinora::clip
