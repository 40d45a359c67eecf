#include "evaluate/picture_shift.h"

#include <cmath>

#include <gtest/gtest.h>

namespace kinora::evaluate {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;

/// Waves of several lengths, which begin `right` pixels further right; of 4 channels it is opaque.
ColorImage waves(double right, int channels) {
  ColorImage image(kWidth, kHeight, channels, 255);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double x = u - right;
      const double value = 128 + 40 * std::sin(0.31 * x + 0.17 * v) + 40 * std::sin(0.13 * x - 0.23 * v) +
                           30 * std::sin(0.57 * x + 0.05 * v);
      for (int c = 0; c < 3; ++c) image.at(u, v, c) = static_cast<std::uint8_t>(std::lround(value));
    }
  }
  return image;
}

TEST(PictureShift, IsZeroBetweenEqualPictures) {
  PictureShift shift;
  shift.add(waves(0, 4), waves(0, 3));
  EXPECT_LT(shift.json().at("shift_median"), 0.02);
  EXPECT_LT(shift.json().at("shift_95"), 0.1);
}

TEST(PictureShift, IsWhatAllLiesBeside) {
  PictureShift shift;
  shift.add(waves(2.5, 4), waves(0, 3));
  EXPECT_NEAR(shift.json().at("shift_median"), 2.5, 0.1);
  EXPECT_NEAR(shift.json().at("shift_95"), 2.5, 0.5);
}

TEST(PictureShift, IsOverAllPicturesTogether) {
  PictureShift shift;
  for (int i = 0; i < 9; ++i) shift.add(waves(0, 4), waves(0, 3));
  shift.add(waves(4, 4), waves(0, 3));
  EXPECT_LT(shift.json().at("shift_median"), 0.1);
  EXPECT_NEAR(shift.json().at("shift_95"), 4, 0.5);
}

TEST(PictureShift, LeavesOutWhatIsNotDrawn) {
  ColorImage drawn = waves(3, 4);
  const ColorImage still = waves(0, 4);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      if (u < kWidth / 2) drawn.at(u, v, 3) = 0;
      if (u >= kWidth / 2) std::copy_n(still.pixel(u, v), 4, drawn.pixel(u, v));
    }
  }
  PictureShift shift;
  shift.add(drawn, waves(0, 3));
  EXPECT_LT(shift.json().at("shift_median"), 0.1);
}

TEST(PictureShift, IsUnknownWhereNothingIsDrawn) {
  PictureShift shift;
  shift.add(ColorImage(kWidth, kHeight, 4), waves(0, 3));
  shift.add(ColorImage(8, 8, 4, 255), ColorImage(8, 8, 3)); // too small
  EXPECT_TRUE(shift.json().at("shift_median").is_null());
  EXPECT_TRUE(shift.json().at("shift_95").is_null());
}

} // namespace
} // namespace kinora::evaluate
