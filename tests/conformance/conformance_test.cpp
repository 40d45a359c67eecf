// Files of every version that was ever written, and what they must decode to: no later version may break them.
#include <array>
#include <span>

#include <gtest/gtest.h>

#include "clip/clip_io.h"
#include "container/crc32c.h"
#include "support/source_folder.h"

namespace kinora::clip {
namespace {

using Checksums = std::array<std::uint32_t, 3>;

// Of table, density net and colour net as little-endian floats.
Checksums checksums(const fields::Field& field) {
  const auto of = [](const auto& values) { return container::crc32c(std::as_bytes(std::span(values))); };
  return {of(field.table), of(field.density_net), of(field.color_net)};
}

void expect_fields(const char* file, const std::array<Checksums, 3>& expected) {
  const Clip clip = read_clip(test::source_folder() / "tests" / "conformance" / file);
  ASSERT_EQ(clip.layers.size(), 3U);
  EXPECT_EQ(clip.times.size(), 4U);
  for (std::size_t l = 0; l < 3; ++l) EXPECT_EQ(checksums(clip.layers[l].field), expected[l]) << clip.layers[l].name;
}

TEST(Conformance, FieldsOfVersions3And4DecodeToTheSameBits) {
  expect_fields("clip_fields_3_and_4.mkv", {{{0x713C3E6F, 0x9F46A76E, 0x62145567},
                                             {0x8AD07818, 0x37BF03A1, 0x5BF0AF95},
                                             {0xD7BE131F, 0xF1CFE6F4, 0x3176A5A6}}});
}

} // namespace
} // namespace kinora::clip
