#include "fields/rendering/tile_changes.h"

#include <array>
#include <set>

#include <gtest/gtest.h>

#include "core/random.h"

namespace kinora::fields {
namespace {

constexpr int kTile = TileChanges::kTile;

/// The pixels, by their first sample, whose samples are touched, or lie between others of which one is; and all samples
/// that those look at.
struct Expected {
  std::set<int> changed, needed;
};

std::array<int, 4> neighbours(int sample) {
  const int u = sample % kTile, v = sample / kTile;
  return {u > 0 ? sample - 1 : sample + 1, u + 1 < kTile ? sample + 1 : sample - 1,
          v > 0 ? sample - kTile : sample + kTile, v + 1 < kTile ? sample + kTile : sample - kTile};
}
bool is_between(int sample) { return (sample % kTile + sample / kTile) % 2 != 0; }
int pixel_of(int sample, int per_side) {
  const int u = sample % kTile, v = sample / kTile;
  return (v - v % per_side) * kTile + u - u % per_side;
}

Expected expected(const std::set<int>& touched, int per_side) {
  Expected result;
  for (int s = 0; s < kTile * kTile; ++s) {
    bool changes = touched.contains(s);
    for (const int n : neighbours(s)) changes |= is_between(s) && touched.contains(n);
    if (changes) result.changed.insert(pixel_of(s, per_side));
  }
  for (int s = 0; s < kTile * kTile; ++s) {
    if (!result.changed.contains(pixel_of(s, per_side))) continue;
    result.needed.insert(s);
    for (const int n : neighbours(s)) {
      if (is_between(s)) result.needed.insert(n);
    }
  }
  return result;
}

TEST(TileChanges, AreWhatFillingPixelsWouldLookAt) {
  Random random(5);
  for (const int per_side : {1, 2, 4, 8}) {
    for (int round = 0; round < 200; ++round) {
      std::set<int> touched;
      TileChanges::Samples samples{};
      for (std::uint64_t i = random.below(1 + 200 * random.below(2)); i > 0; --i) {
        const auto s = static_cast<int>(random.below(kTile * kTile));
        touched.insert(s);
        samples.at(static_cast<std::size_t>(s / kTile)) |= static_cast<std::uint16_t>(1U << s % kTile);
      }
      if (round == 0) touched = {0}, samples = {1};
      TileChanges changes;
      changes.find(samples, per_side);
      const Expected wanted = expected(touched, per_side);
      for (int s = 0; s < kTile * kTile; ++s) {
        const auto sample = static_cast<std::size_t>(s);
        ASSERT_EQ(changes.changed(sample), wanted.changed.contains(pixel_of(s, per_side))) << s << " of " << per_side;
        ASSERT_EQ(changes.needed(sample), wanted.needed.contains(s)) << s << " of " << per_side;
      }
    }
  }
}

TEST(TileChanges, AreNoneWhereNothingMoves) {
  TileChanges changes;
  changes.set_all();
  EXPECT_TRUE(changes.changed(17) && changes.needed(255));
  changes.find({}, 1);
  for (std::size_t s = 0; s < std::size_t{kTile} * kTile; ++s) EXPECT_FALSE(changes.changed(s) || changes.needed(s));
}

} // namespace
} // namespace kinora::fields
