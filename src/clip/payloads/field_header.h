// What stands before the coded parts of a S_KINORA/FIELD payload. docs/container.md specifies it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "clip/coding/zstd_codec.h"
#include "fields/model/field.h"

namespace kinora::clip {

// Versions of payloads. 1 and 2 had no vectors among the features; 3 and 4 are still read.
inline constexpr std::uint8_t kZstdDensityVersion = 3;
inline constexpr std::uint8_t kFieldVersion = 5;
inline constexpr std::uint8_t kFieldDifferenceVersion = 6; ///< the same, of differences to another field
inline constexpr std::uint8_t kCoarseFieldVersion = 7;     ///< without the finer levels, which follow
inline constexpr std::uint8_t kFinerLevelVersion = 8;      ///< one of those; it has no header of this kind
inline constexpr std::size_t kMatrices = 5;

struct FieldHeader {
  std::uint8_t version = kFieldVersion;
  fields::FieldConfig config;
  float sharpness = 0;                 ///< of a field of signed distances
  std::vector<int> exponents;          ///< one per level, then (not in versions 3 and 4) one per matrix
  std::vector<std::size_t> part_bytes; ///< of what follows the header, in its order
  int levels_here = 0;                 ///< of a coarse field; those that follow have exponent 0 and no bytes here
  std::size_t bytes = 0;               ///< of the header
};

/// Appends a header of kFieldVersion, kFieldDifferenceVersion or kCoarseFieldVersion. Throws Error(kFailure) if the
/// sharpness is not finite.
void put_header(Bytes& out, const FieldHeader& header);

/// Safe for untrusted input. Throws Error(kCorruptInput) naming `location`, also if the parts do not fill the payload.
FieldHeader get_header(std::span<const std::byte> payload, const std::string& location);

/// An exponent that dequantise() takes. Throws Error(kCorruptInput).
int checked_exponent(int exponent, const std::string& location);

/// A finite 16-bit float. Throws Error(kCorruptInput).
float get_half(std::span<const std::byte> bytes, std::size_t at, const std::string& location);

/// The weights of both nets, matrix by matrix: density (2), then colour (3).
std::array<std::span<float>, kMatrices> matrices_of(fields::Field& field);
std::array<std::span<const float>, kMatrices> matrices_of(const fields::Field& field);

} // namespace kinora::clip
