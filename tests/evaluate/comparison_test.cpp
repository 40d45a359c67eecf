#include "evaluate/comparison.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "clip/sample_clip.h"

namespace kinora::evaluate {
namespace {

constexpr int kWidth = 40;
constexpr int kHeight = 30;

ingest::Frame gray_frame() {
  ingest::Frame frame;
  frame.color = ColorImage(kWidth, kHeight, 3, 100);
  frame.depth = DepthImage(kWidth, kHeight, 1, 2.0F);
  frame.labels = LabelImage(kWidth, kHeight);
  for (int v = 10; v < 20; ++v) {
    for (int u = 10; u < 20; ++u) frame.labels.at(u, v) = 2;
  }
  return frame;
}

fields::Picture gray_picture(std::uint8_t gray, float depth) {
  fields::Picture picture{ColorImage(kWidth, kHeight, 4, gray), DepthImage(kWidth, kHeight, 1, depth), {}};
  for (std::size_t i = 0; i < picture.color.pixel_count(); ++i) picture.color.data()[4 * i + 3] = 255;
  return picture;
}

const Subject kBackground{"background", "", {0}, std::set{0}, true};
const Subject kObject{"object", "", {1}, std::set{2}, false};

TEST(Comparison, EqualPicturesHaveTheHighestPsnr) {
  Means means;
  compare(gray_picture(100, 2), gray_frame(), kBackground, means);
  EXPECT_EQ(means.frames(), 1);
  EXPECT_EQ(means.mean("psnr"), 100);
  EXPECT_EQ(means.mean("mae"), 0);
  EXPECT_EQ(means.mean("depth_error_median"), 0);
  EXPECT_EQ(means.mean("depth_coverage"), 1);
}

TEST(Comparison, TenGrayLevelsAreTwentyEightDecibel) {
  Means means;
  compare(gray_picture(110, 2), gray_frame(), kBackground, means);
  EXPECT_NEAR(means.mean("psnr").value(), 28.1308, 1e-4);
  EXPECT_NEAR(means.mean("mae").value(), 10, 1e-9);
}

TEST(Comparison, WrongPixelsOfAnotherLabelDoNotCount) {
  fields::Picture picture = gray_picture(100, 2);
  for (int v = 10; v < 20; ++v) {
    for (int u = 10; u < 20; ++u) picture.color.at(u, v, 0) = 0;
  }
  Means means;
  compare(picture, gray_frame(), kBackground, means);
  EXPECT_EQ(means.mean("psnr"), 100);
}

TEST(Comparison, BackgroundIsJudgedOnlyWhereDepthWasMeasured) {
  ingest::Frame frame = gray_frame();
  for (int u = 0; u < kWidth; ++u) {
    frame.depth.at(u, 0) = 0;
    for (int c = 0; c < 3; ++c) frame.color.at(u, 0, c) = 255;
  }
  Means means;
  compare(gray_picture(100, 2), frame, kBackground, means);
  EXPECT_EQ(means.mean("psnr"), 100);
}

TEST(Comparison, ObjectThatSpillsOverItsMaskLosesInTheBoxAndOverlap) {
  Means means;
  compare(gray_picture(100, 2), gray_frame(), kObject, means);
  EXPECT_EQ(means.mean("psnr"), 100);
  EXPECT_EQ(means.mean("psnr_inside"), 100);
  EXPECT_LT(means.mean("psnr_box").value(), 12);
  EXPECT_NEAR(means.mean("iou").value(), 100.0 / (kWidth * kHeight), 1e-9);
}

TEST(Comparison, TransparentObjectIsBlackInsideItsMask) {
  fields::Picture picture = gray_picture(100, 2);
  for (std::size_t i = 0; i < picture.color.pixel_count(); ++i) picture.color.data()[4 * i + 3] = 0;
  Means means;
  compare(picture, gray_frame(), kObject, means);
  EXPECT_NEAR(means.mean("mae").value(), 100, 1e-9);
}

TEST(Comparison, UndrawnDepthIsInfinitelyWrong) {
  fields::Picture picture = gray_picture(100, 2.01F);
  Means mostly_drawn;
  for (int u = 0; u < kWidth; ++u) picture.depth.at(u, 0) = 0;
  compare(picture, gray_frame(), kBackground, mostly_drawn);
  EXPECT_NEAR(mostly_drawn.mean("depth_error_median").value(), 0.01, 1e-5);
  EXPECT_LT(mostly_drawn.mean("depth_coverage").value(), 1);

  Means undrawn;
  compare(gray_picture(100, 0), gray_frame(), kBackground, undrawn);
  EXPECT_EQ(undrawn.mean("depth_error_median"), std::numeric_limits<double>::infinity());
  EXPECT_TRUE(undrawn.json().at("depth_error_median").is_null());
}

TEST(Comparison, OfTheWholePictureWhatIsNotDrawnIsBlack) {
  ingest::Frame frame = gray_frame();
  std::fill(frame.depth.values().begin(), frame.depth.values().end(), 0.0F); // nothing measured: judged all the same
  fields::Picture picture = gray_picture(100, 2);
  for (int u = 0; u < kWidth; ++u) picture.color.at(u, 0, 3) = 0;
  const Subject everything{"picture", "every pixel", {0, 1}, {}, false};
  Means means;
  compare(picture, frame, everything, means);
  EXPECT_NEAR(means.mean("mae").value(), 100.0 / kHeight, 1e-9);
  EXPECT_NEAR(means.mean("coverage").value(), 1 - 1.0 / kHeight, 1e-9);
}

TEST(Comparison, FrameWithoutTheLabelIsLeftOut) {
  ingest::Frame frame = gray_frame();
  frame.labels = LabelImage(kWidth, kHeight);
  Means means;
  compare(gray_picture(100, 2), frame, kObject, means);
  EXPECT_EQ(means.frames(), 0);
  EXPECT_FALSE(means.mean("psnr").has_value());
}

TEST(Comparison, WhatIsNotDrawnOfAPictureIsBlackAlsoWithoutDepth) {
  const player::Player player(clip::testing::sample_clip(1, 2, false));
  ingest::Frame frame = gray_frame();
  fields::Picture picture = gray_picture(100, 2);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth / 2; ++u) {
      frame.depth.at(u, v) = 0;
      picture.color.at(u, v, 3) = 0;
    }
  }
  Means means;
  compare(picture, frame, picture_subject(player), means);
  EXPECT_NEAR(means.mean("coverage").value(), 0.5, 1e-9);
  EXPECT_NEAR(means.mean("psnr").value(), -10 * std::log10(0.5 * 100 * 100 / (255.0 * 255.0)), 1e-4);
}

} // namespace
} // namespace kinora::evaluate
