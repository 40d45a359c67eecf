// What the files of this folder decode to: bits that no later version, and no machine, may change.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "container/crc32c.h"
#include "fields/model/field.h"

namespace kinora::conformance {

/// Of table, density net and colour net as little-endian floats.
using Checksums = std::array<std::uint32_t, 3>;

inline Checksums checksums(const fields::Field& field) {
  const auto of = [](const auto& values) { return container::crc32c(std::as_bytes(std::span(values))); };
  return {of(field.table), of(field.density_net), of(field.color_net)};
}

struct ExpectedFields {
  const char* file;
  std::size_t frames;
  std::array<Checksums, 3> layers;
};

inline constexpr std::array<ExpectedFields, 1> kExpectedFields{{{"clip_fields_3_and_4.mkv",
                                                                 4,
                                                                 {{{0x713C3E6F, 0x9F46A76E, 0x62145567},
                                                                   {0x8AD07818, 0x37BF03A1, 0x5BF0AF95},
                                                                   {0xD7BE131F, 0xF1CFE6F4, 0x3176A5A6}}}}}};

} // namespace kinora::conformance
