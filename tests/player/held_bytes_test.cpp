#include "player/held_bytes.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/random.h"

namespace kinora::player {
namespace {

std::vector<std::byte> numbered(std::size_t count) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i < count; ++i) bytes.push_back(static_cast<std::byte>(i * 7 + i / 256));
  return bytes;
}

TEST(HeldBytes, AreTheFileInWhateverOrderTheyCame) {
  const std::vector<std::byte> file = numbered(1000);
  for (int run = 0; run < 50; ++run) {
    Random random(static_cast<std::uint64_t>(run), 0);
    HeldBytes held;
    std::vector<bool> there(file.size(), false);
    while (held.size() < file.size()) {
      const auto begin = static_cast<std::size_t>(random.uniform() * 990);
      const auto count = std::min(file.size() - begin, static_cast<std::size_t>(1 + random.uniform() * 99));
      held.add(begin, std::span(file).subspan(begin, count));
      std::fill_n(there.begin() + static_cast<std::ptrdiff_t>(begin), count, true);
      ASSERT_EQ(held.size(), static_cast<std::size_t>(std::ranges::count(there, true)));
      const auto from = static_cast<std::size_t>(random.uniform() * 999);
      const auto gap = std::find(there.begin() + static_cast<std::ptrdiff_t>(from), there.end(), false);
      const auto missing = held.missing(from, file.size());
      ASSERT_EQ(missing.has_value(), gap != there.end());
      if (!missing) continue;
      const auto end = std::find(gap, there.end(), true);
      ASSERT_EQ(missing->begin, static_cast<std::uint64_t>(gap - there.begin()));
      ASSERT_EQ(missing->end, static_cast<std::uint64_t>(end - there.begin()));
      std::vector<std::byte> pieces;
      for (std::size_t i = 0; i < file.size(); ++i) {
        if (there[i]) pieces.push_back(file[i]);
      }
      ASSERT_TRUE(std::ranges::equal(held.all(), pieces));
      const auto first_gap = std::ranges::find(there, false) - there.begin();
      ASSERT_TRUE(std::ranges::equal(held.front(), std::span(file).first(static_cast<std::size_t>(first_gap))));
      if (random.uniform() < 0.02F) held.add(0, file);
      if (held.size() == file.size()) break;
    }
    EXPECT_TRUE(std::ranges::equal(held.all(), file));
    EXPECT_FALSE(held.missing(0, file.size()));
    EXPECT_EQ(held.missing(0, file.size() + 5), (container::ByteRange{file.size(), file.size() + 5}));
  }
}

TEST(HeldBytes, AreReplacedWhereTheyAre) {
  HeldBytes held;
  const std::vector<std::byte> file = numbered(20), other(5, std::byte{1});
  held.add(0, file);
  held.replace(3, other);
  EXPECT_EQ(held.size(), file.size());
  EXPECT_TRUE(std::ranges::equal(held.all().subspan(3, 5), other));
  EXPECT_TRUE(std::ranges::equal(held.all().subspan(8), std::span(file).subspan(8)));
  held.clear();
  EXPECT_EQ(held.size(), 0U);
  EXPECT_TRUE(held.front().empty());
}

} // namespace
} // namespace kinora::player
