#include "evaluate/moving_pixels.h"

#include <numeric>

#include <gtest/gtest.h>

#include "ingest/capture/frames_capture.h"

namespace kinora::evaluate {
namespace {

constexpr int kWidth = 20;
constexpr int kHeight = 10;

ingest::Frame grey(std::uint8_t level) {
  ingest::Frame frame;
  frame.camera.intrinsics = {kWidth, kHeight, 20, 20, 9.5, 4.5};
  frame.color = ColorImage(kWidth, kHeight, 3, level);
  return frame;
}

int moving_in(const std::vector<ingest::Frame>& frames, const ColorImage& color) {
  ingest::testing::FramesCapture capture(frames);
  const auto moving = MovingPixels::of(capture);
  if (!moving) return -1;
  const LabelImage found = moving->in(color);
  return std::accumulate(found.values().begin(), found.values().end(), 0);
}

TEST(MovingPixels, DifferFromTheirMedianByMoreThanTwelveLevels) {
  const std::vector<ingest::Frame> frames{grey(100), grey(104), grey(240)};
  EXPECT_EQ(moving_in(frames, grey(116).color), 0);
  EXPECT_EQ(moving_in(frames, grey(117).color), kWidth * kHeight);
  EXPECT_EQ(moving_in(frames, grey(92).color), 0);
  EXPECT_EQ(moving_in(frames, grey(91).color), kWidth * kHeight);
}

TEST(MovingPixels, ChangeIsTheMeanOverTheChannels) {
  const std::vector<ingest::Frame> frames(3, grey(100));
  ColorImage color = grey(100).color;
  color.at(5, 5, 1) = 136;
  EXPECT_EQ(moving_in(frames, color), 0);
  color.at(5, 5, 1) = 137;
  EXPECT_EQ(moving_in(frames, color), 9) << "a pixel and its eight neighbours";
}

TEST(MovingPixels, AreNoneAtThePicturesEdgeButThoseInIt) {
  ColorImage color = grey(100).color;
  color.at(0, 0, 0) = 255;
  EXPECT_EQ(moving_in(std::vector<ingest::Frame>(3, grey(100)), color), 4);
}

TEST(MovingPixels, AreNotToldFromTwoFrames) {
  EXPECT_EQ(moving_in(std::vector<ingest::Frame>(2, grey(100)), grey(200).color), -1);
}

TEST(MovingPixels, MedianIsOverFramesOfTheWholeCapture) {
  // What shows for most of 400 frames is still, though the first 120 show something else.
  std::vector<ingest::Frame> frames(150, grey(50));
  frames.resize(400, grey(150));
  EXPECT_EQ(moving_in(frames, grey(150).color), 0);
  EXPECT_EQ(moving_in(frames, grey(50).color), kWidth * kHeight);
}

} // namespace
} // namespace kinora::evaluate
