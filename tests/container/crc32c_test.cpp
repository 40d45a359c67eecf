#include "container/crc32c.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "ebml_builder.h"
#include "sample_file.h"

namespace kinora::container {
namespace {

using testing::bytes_of;
using testing::random_bytes;

// RFC 3720, appendix B.4.
TEST(Crc32c, GivesTheValuesOfRfc3720) {
  Bytes ascending;
  for (int i = 0; i < 32; ++i) ascending.push_back(static_cast<std::byte>(i));
  EXPECT_EQ(crc32c(Bytes(32, std::byte{0})), 0x8A9136AAU);
  EXPECT_EQ(crc32c(Bytes(32, std::byte{0xFF})), 0x62A8AB43U);
  EXPECT_EQ(crc32c(ascending), 0x46DD794EU);
  EXPECT_EQ(crc32c(bytes_of("123456789")), 0xE3069283U);
}

TEST(Crc32c, OfPartsIsThatOfTheWhole) {
  Random random(1);
  const Bytes bytes = random_bytes(random, 100);
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    const std::span<const std::byte> all(bytes);
    EXPECT_EQ(crc32c(all.subspan(cut), crc32c(all.first(cut))), crc32c(all)) << cut;
  }
}

} // namespace
} // namespace kinora::container
