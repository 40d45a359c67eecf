#include "fields/rendering/upsampling.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace kinora::fields {
namespace {

Picture random_picture(int width, int height, std::uint64_t seed) {
  Random random(seed);
  Picture picture{ColorImage(width, height, 4), DepthImage(width, height), LabelImage(width, height)};
  for (std::uint8_t& byte : picture.color.values()) byte = static_cast<std::uint8_t>(random.below(256));
  for (float& depth : picture.depth.values()) depth = random.uniform() < 0.3F ? 0 : 1 + random.uniform();
  for (std::uint8_t& front : picture.front.values()) front = static_cast<std::uint8_t>(random.below(3));
  return picture;
}

TEST(Upsampling, ToTheSameSizeChangesNothing) {
  const Picture picture = random_picture(13, 7, 1);
  const Picture same = upsampled(picture, 13, 7);
  for (std::size_t i = 0; i < picture.depth.values().size(); ++i) {
    EXPECT_EQ(same.depth.values()[i], picture.depth.values()[i]);
    EXPECT_EQ(same.front.values()[i], picture.front.values()[i]);
    const std::uint8_t* a = same.color.data() + 4 * i;
    const std::uint8_t* b = picture.color.data() + 4 * i;
    EXPECT_EQ(a[3], b[3]);
    for (int c = 0; c < 3 && b[3] > 0; ++c) EXPECT_EQ(a[c], b[c]);
  }
}

TEST(Upsampling, WhatIsTransparentGivesNoColour) {
  Picture small{ColorImage(2, 1, 4), DepthImage(2, 1), LabelImage(2, 1)};
  const std::array<std::uint8_t, 8> pixels{200, 100, 50, 255, 9, 9, 9, 0};
  std::copy(pixels.begin(), pixels.end(), small.color.data());
  const Picture large = upsampled(small, 8, 3);
  for (int u = 0; u < 8; ++u) {
    const std::uint8_t* pixel = large.color.pixel(u, 1);
    if (pixel[3] == 0) continue;
    EXPECT_EQ(pixel[0], 200) << u;
    EXPECT_EQ(pixel[2], 50) << u;
    if (u > 0) {
      EXPECT_LE(pixel[3], large.color.pixel(u - 1, 1)[3]);
    }
  }
  EXPECT_EQ(large.color.pixel(0, 0)[3], 255);
  EXPECT_EQ(large.color.pixel(7, 2)[3], 0);
}

TEST(Upsampling, DepthIsInterpolatedOnASurfaceAndNeverAcrossAnEdge) {
  Picture small{ColorImage(4, 1, 4), DepthImage(4, 1), LabelImage(4, 1)};
  const std::array<float, 4> depths{1.00F, 1.01F, 2.00F, 0.0F};
  std::copy(depths.begin(), depths.end(), small.depth.data());
  const Picture large = upsampled(small, 16, 1);
  for (int u = 0; u < 16; ++u) {
    const float depth = large.depth.at(u, 0);
    EXPECT_TRUE((depth >= 1 && depth <= 1.01F) || depth == 2 || depth == 0) << u << ": " << depth;
  }
  EXPECT_NEAR(large.depth.at(3, 0), 1.00375F, 1e-5); // a place in between: (3.5 / 4 − 0.5) of the way
}

TEST(Upsampling, OnePixelFillsAPicture) {
  const Picture picture = random_picture(1, 1, 4);
  const Picture large = upsampled(picture, 3, 5);
  for (const float depth : large.depth.values()) EXPECT_EQ(depth, picture.depth.values()[0]);
}

} // namespace
} // namespace kinora::fields
