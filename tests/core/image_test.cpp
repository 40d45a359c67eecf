#include "core/image.h"

#include <gtest/gtest.h>

namespace kinora {
namespace {

TEST(Image, IsRowMajorWithInterleavedChannels) {
  ColorImage image(3, 2, 4);
  image.at(2, 1, 3) = 9;
  EXPECT_EQ(image.values().size(), 24U);
  EXPECT_EQ(image.values()[(1 * 3 + 2) * 4 + 3], 9);
  EXPECT_EQ(image.pixel(2, 1)[3], 9);
  EXPECT_EQ(image.pixel(1, 0), image.data() + 4);
}

TEST(Image, CopiesItsPixels) {
  DepthImage original(2, 2, 1, 1.5F);
  DepthImage copy = original;
  copy.at(0, 0) = 2.0F;
  EXPECT_EQ(original.at(0, 0), 1.5F);
}

TEST(Image, KnowsWhatItContains) {
  const LabelImage image(3, 2);
  EXPECT_TRUE(image.contains(0, 0));
  EXPECT_TRUE(image.contains(2, 1));
  for (const auto& [u, v] : {std::pair{-1, 0}, {0, -1}, {3, 0}, {0, 2}}) EXPECT_FALSE(image.contains(u, v));
  EXPECT_EQ(image.pixel_count(), 6U);
}

TEST(Image, DefaultIsEmpty) {
  EXPECT_TRUE(ColorImage().empty());
  EXPECT_FALSE(ColorImage(1, 1, 3).empty());
}

TEST(Image, ComparesSizesAcrossTypesAndChannels) {
  EXPECT_TRUE(ColorImage(3, 2, 4).same_size(DepthImage(3, 2)));
  EXPECT_FALSE(ColorImage(3, 2, 3).same_size(LabelImage(2, 3)));
}

} // namespace
} // namespace kinora
