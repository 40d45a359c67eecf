// Bytes that wait beside their output.
#include "common/byte_spool.h"

#include <gtest/gtest.h>

#include <numeric>

#include "core/error.h"
#include "formats/sample_capture.h"

namespace kinora::formats {
namespace {

TEST(ByteSpool, BytesComeBackWholeAndNoFileIsSeen) {
  const test::TemporaryFolder folder;
  ByteSpool spool(folder.path() / "out.glb");
  std::vector<std::byte> piece(3'000'001);
  for (std::size_t i = 0; i < piece.size(); ++i) piece[i] = static_cast<std::byte>(i * 7 / 5);
  constexpr int kPieces = 15;
  for (int i = 0; i < kPieces; ++i) {
    piece[0] = static_cast<std::byte>(i + 1);
    spool.append(piece);
    spool.pad(4);
    EXPECT_EQ(spool.size(), static_cast<std::size_t>(i + 1) * 3'000'004);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  std::vector<std::byte> read;
  spool.read([&read](std::span<const std::byte> part) { read.insert(read.end(), part.begin(), part.end()); });
  ASSERT_EQ(read.size(), spool.size());
  for (int i = 0; i < kPieces; ++i) {
    const auto begin = read.begin() + i * 3'000'004;
    piece[0] = static_cast<std::byte>(i + 1);
    EXPECT_TRUE(std::equal(piece.begin(), piece.end(), begin)) << i;
    EXPECT_EQ(begin[3'000'003], std::byte{0});
  }
}

TEST(ByteSpool, WhereNoFileCanBeMadeTheOutputIsNamed) {
  ByteSpool spool("/proc/out.glb");
  try {
    spool.append(std::vector<std::byte>(17 << 20));
    FAIL() << "it is not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUnwritableOutput);
    EXPECT_NE(std::string(error.what()).find("/proc/out.glb"), std::string::npos);
  }
}

} // namespace
} // namespace kinora::formats
