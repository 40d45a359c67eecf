#include "container/lacing.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace kinora::container {
namespace {

Bytes bytes_of(std::initializer_list<int> values) {
  Bytes bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

std::vector<std::size_t> sizes_of(const Bytes& block, Lacing lacing) {
  std::vector<std::size_t> sizes;
  for (const auto& frame : laced_frames(block, lacing)) sizes.push_back(frame.size());
  return sizes;
}

/// A block whose frames begin with their numbers.
Bytes with_frames(Bytes head, const std::vector<std::size_t>& sizes) {
  for (std::size_t i = 0; i < sizes.size(); ++i) head.insert(head.end(), sizes[i], static_cast<std::byte>(i));
  return head;
}

// The examples of RFC 9559, section 10.3: frames of 800, 500 and 1000 bytes.
TEST(Lacing, OfTheStandardsExamples) {
  const std::vector<std::size_t> sizes{800, 500, 1000};
  const Bytes xiph = with_frames(bytes_of({2, 255, 255, 255, 35, 255, 245}), sizes);
  const Bytes ebml = with_frames(bytes_of({2, 0x43, 0x20, 0x5E, 0xD3}), sizes);
  for (const auto& [block, lacing] : {std::pair{xiph, Lacing::kXiph}, {ebml, Lacing::kEbml}}) {
    EXPECT_EQ(sizes_of(block, lacing), sizes);
    const auto frames = laced_frames(block, lacing);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      EXPECT_EQ(frames[i].front(), static_cast<std::byte>(i));
      EXPECT_EQ(frames[i].back(), static_cast<std::byte>(i));
    }
  }
  const std::vector<std::size_t> equal{800, 800, 800};
  EXPECT_EQ(sizes_of(with_frames(bytes_of({2}), equal), Lacing::kFixed), equal);
}

TEST(Lacing, OfNoneIsTheBlock) {
  EXPECT_EQ(sizes_of(bytes_of({1, 2, 3}), Lacing::kNone), (std::vector<std::size_t>{3}));
}

TEST(Lacing, SizesThatDoNotFitGiveNothing) {
  for (const Lacing lacing : {Lacing::kXiph, Lacing::kFixed, Lacing::kEbml}) {
    EXPECT_TRUE(sizes_of({}, lacing).empty());
    EXPECT_TRUE(sizes_of(bytes_of({2, 0x9F, 0x9F}), lacing).empty() || lacing == Lacing::kFixed);
  }
  EXPECT_TRUE(sizes_of(bytes_of({1, 200, 7}), Lacing::kXiph).empty());
  EXPECT_TRUE(sizes_of(bytes_of({1, 255}), Lacing::kXiph).empty());
  EXPECT_TRUE(sizes_of(bytes_of({2, 7, 7, 7}), Lacing::kFixed) == (std::vector<std::size_t>{1, 1, 1}));
  EXPECT_TRUE(sizes_of(bytes_of({2, 7, 7}), Lacing::kFixed).empty());
  EXPECT_TRUE(sizes_of(bytes_of({2, 0x81, 0x80, 1}), Lacing::kEbml).empty()); // the second is 63 below the first
  EXPECT_TRUE(sizes_of(bytes_of({1, 0, 7}), Lacing::kEbml).empty());
}

TEST(Lacing, OfRandomBytesStaysWithinThem) {
  for (std::uint64_t seed = 0; seed < 20'000; ++seed) {
    Random random(seed);
    Bytes block(random.below(40));
    for (std::byte& byte : block) byte = static_cast<std::byte>(random.below(256));
    for (const Lacing lacing : {Lacing::kNone, Lacing::kXiph, Lacing::kFixed, Lacing::kEbml}) {
      std::size_t sum = 0;
      for (const auto& frame : laced_frames(block, lacing)) {
        sum += frame.size();
        if (!frame.empty()) {
          EXPECT_GE(frame.data(), block.data());
          EXPECT_LE(frame.data() + frame.size(), block.data() + block.size());
        }
      }
      EXPECT_LE(sum, block.size());
    }
  }
}

} // namespace
} // namespace kinora::container
