#include "ingest/depth/undistortion.h"

#include <gtest/gtest.h>

#include "core/sample_images.h"

namespace kinora::ingest {
namespace {

constexpr Intrinsics kCamera{64, 48, 60, 58, 31.5, 23.5};
constexpr Distortion kLens{-0.2, 0.05, 0.003, -0.002, 0.01};

/// Where an ideal pixel lies in the distorted image: the model written out once more, from OpenCV's documentation.
Eigen::Vector2d distorted_pixel(double u, double v) {
  const double x = (u - kCamera.cx) / kCamera.fx;
  const double y = (v - kCamera.cy) / kCamera.fy;
  const double r2 = x * x + y * y;
  const double radial = 1 + kLens.k1 * r2 + kLens.k2 * r2 * r2 + kLens.k3 * r2 * r2 * r2;
  return {kCamera.fx * (x * radial + 2 * kLens.p1 * x * y + kLens.p2 * (r2 + 2 * x * x)) + kCamera.cx,
          kCamera.fy * (y * radial + kLens.p1 * (r2 + 2 * y * y) + 2 * kLens.p2 * x * y) + kCamera.cy};
}

TEST(Undistortion, WithoutDistortionNothingChanges) {
  const Undistortion none(kCamera, {});
  const ColorImage color = test::sample_color(64, 48);
  const ColorImage same = none.color(color);
  for (std::size_t i = 0; i < color.values().size(); ++i) ASSERT_NEAR(same.data()[i], color.data()[i], 1);
}

TEST(Undistortion, ColorOfAGradientLiesWhereTheModelSays) {
  ColorImage distorted(64, 48, 3);
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u) {
      distorted.at(u, v, 0) = static_cast<std::uint8_t>(3 * u);
      distorted.at(u, v, 1) = static_cast<std::uint8_t>(4 * v);
    }
  const ColorImage ideal = Undistortion(kCamera, kLens).color(distorted);
  for (int v = 8; v < 40; ++v)
    for (int u = 8; u < 56; ++u) {
      const Eigen::Vector2d source = distorted_pixel(u, v);
      ASSERT_NEAR(ideal.at(u, v, 0), 3 * source.x(), 0.6);
      ASSERT_NEAR(ideal.at(u, v, 1), 4 * source.y(), 0.6);
    }
}

TEST(Undistortion, DepthTakesTheNearestPixelAndInventsNothing) {
  DepthImage distorted(64, 48, 1, 1.0F);
  for (int v = 0; v < 48; ++v)
    for (int u = 32; u < 64; ++u) distorted.at(u, v) = 3.0F;
  const DepthImage ideal = Undistortion(kCamera, kLens).depth(distorted);
  for (int v = 4; v < 44; ++v)
    for (int u = 4; u < 60; ++u) {
      const Eigen::Vector2d source = distorted_pixel(u, v);
      ASSERT_EQ(ideal.at(u, v), std::lround(source.x()) < 32 ? 1.0F : 3.0F) << u << " " << v;
    }
}

TEST(Undistortion, WhatTheLensNeverSawIsEmpty) {
  const Undistortion outward(kCamera, {0.5, 0, 0, 0, 0}); // the ideal image's corners lie outside the distorted one
  EXPECT_EQ(outward.depth(DepthImage(64, 48, 1, 1.0F)).at(0, 0), 0);
  EXPECT_EQ(outward.labels(LabelImage(64, 48, 1, 5)).at(0, 0), 0);
  EXPECT_EQ(outward.color(ColorImage(64, 48, 3, 200)).at(0, 0, 0), 0);
  EXPECT_EQ(outward.labels(LabelImage(64, 48, 1, 5)).at(32, 24), 5);
}

TEST(Undistortion, HopelessLensesGiveEmptyPixelsInsteadOfFaults) {
  const Undistortion wild(kCamera, {99, -99, 99, 99, 99});
  EXPECT_TRUE(wild.depth(DepthImage(64, 48, 1, 1.0F)).same_size(DepthImage(64, 48)));
}

} // namespace
} // namespace kinora::ingest
