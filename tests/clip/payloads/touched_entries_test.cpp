#include "clip/payloads/touched_entries.h"

#include <gtest/gtest.h>

#include "clip/sample_clip.h"
#include "fields/network/reference.h"

namespace kinora::clip {
namespace {

using fields::Field;
using fields::FieldConfig;

// Every entry that the field's own interpolation reads, at random points of occupied cells and at their corners.
void expect_reads_only_touched(const Field& field) {
  const auto levels = fields::grid_levels(field.config);
  const auto touched = touched_entries(field.config, field.occupancy);
  Random random(4);
  const int r = field.config.occupancy_resolution;
  for (int z = 0; z < r; ++z) {
    for (int y = 0; y < r; ++y) {
      for (int x = 0; x < r; ++x) {
        if (!field.occupancy.at(x, y, z)) continue;
        for (int s = 0; s < 12; ++s) {
          const auto at = [&](int cell) {
            const float inside = s < 8 ? random.uniform() : static_cast<float>(random.below(2));
            return (static_cast<float>(cell) + inside) / static_cast<float>(r);
          };
          const std::array<float, 3> position{at(x), at(y), at(z)};
          for (std::size_t l = 0; l < levels.size(); ++l) {
            fields::reference::for_each_corner<float>(levels[l], position, [&](std::size_t entry, float) {
              EXPECT_TRUE(std::binary_search(touched[l].begin(), touched[l].end(),
                                             static_cast<std::uint32_t>(entry - levels[l].offset)));
            });
          }
        }
      }
    }
  }
}

TEST(TouchedEntries, HoldEverythingThatIsReadInOccupiedCells) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) expect_reads_only_touched(testing::random_field(seed));
}

TEST(TouchedEntries, HoldEverythingThatIsReadInGridsFinerThanTheOccupancy) {
  FieldConfig config = testing::small_config();
  config.finest_resolution = 777;
  config.log2_table_size = 14;
  expect_reads_only_touched(testing::random_field(5, config));
}

TEST(TouchedEntries, HoldEverythingThatIsReadAtTheBoxsFaces) {
  Field field(testing::small_config());
  const int last = field.config.occupancy_resolution - 1;
  field.occupancy.set(0, 0, 0);
  field.occupancy.set(last, last, last);
  expect_reads_only_touched(field);
}

TEST(TouchedEntries, AreFewForAFewCellsAndNoneForEmptySpace) {
  FieldConfig config = testing::small_config();
  config.log2_table_size = 16;
  Field field(config);
  for (const auto& level : touched_entries(config, field.occupancy)) EXPECT_TRUE(level.empty());
  field.occupancy.set(10, 20, 30);
  for (const auto& level : touched_entries(config, field.occupancy)) EXPECT_LE(level.size(), 64U);
}

TEST(TouchedEntries, AreAllWhereCountingThemWouldTakeTooLong) {
  FieldConfig config = testing::small_config();
  config.finest_resolution = 8192;
  Field field(config);
  for (std::uint64_t& word : field.occupancy.words()) word = ~std::uint64_t{0};
  const auto levels = fields::grid_levels(config);
  EXPECT_EQ(touched_entries(config, field.occupancy).back().size(), levels.back().size);
}

} // namespace
} // namespace kinora::clip
