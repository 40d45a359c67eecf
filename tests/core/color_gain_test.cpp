#include "core/color_gain.h"

#include <cstdlib>

#include <gtest/gtest.h>

namespace kinora {
namespace {

TEST(GainTables, OneChangesNothing) {
  const GainTables same{ColorGain{}};
  for (int value = 0; value < 256; ++value) {
    for (int c = 0; c < 3; ++c) EXPECT_EQ(same(c, static_cast<std::uint8_t>(value)), value);
  }
}

TEST(GainTables, ActOnLinearLightAndOnEachColourByItself) {
  const GainTables tables{ColorGain{{0.5F, 1, 2}}};
  EXPECT_EQ(tables(0, 188), 137); // 0.5029 of the light: half of that is 0.2515
  EXPECT_EQ(tables(1, 188), 188);
  EXPECT_EQ(tables(2, 137), 188);
}

TEST(GainTables, TheInverseTakesBackWhatDoesNotSaturate) {
  const ColorGain gain{{0.8F, 1.1F, 1.3F}};
  const GainTables there(gain), back(gain.inverse());
  for (int value = 0; value < 220; ++value) {
    for (int c = 0; c < 3; ++c) {
      const int again = back(c, there(c, static_cast<std::uint8_t>(value)));
      EXPECT_LE(std::abs(again - value), 1) << value << " of colour " << c;
    }
  }
}

TEST(GainTables, WhatMayBeSaturatedIsNotMadeDarker) {
  const GainTables darker{ColorGain{{0.5F, 0.5F, 0.5F}}};
  EXPECT_LT(darker(0, GainTables::kSaturated - 1), 190);
  EXPECT_EQ(darker(0, GainTables::kSaturated), GainTables::kSaturated);
  EXPECT_EQ(darker(0, 255), 255);
}

TEST(GainTables, OfAPictureAlphaStays) {
  ColorImage picture(2, 1, 4, 100);
  GainTables{ColorGain{{2, 2, 2}}}.apply_to(picture);
  EXPECT_GT(picture.at(1, 0, 2), 130);
  EXPECT_EQ(picture.at(1, 0, 3), 100);
}

} // namespace
} // namespace kinora
