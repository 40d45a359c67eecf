#include "ingest/calibration/stream_delay.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace kinora::ingest {
namespace {

double srgb_of(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

/// A still wall under a gain; a dark patch at `position` moves over it, in depth `delay` frames later than in colour.
Frame frame_of(int index, double gain, double color_position, double depth_position) {
  Frame frame;
  frame.index = index;
  frame.time = index / 30.0;
  frame.color = ColorImage(192, 144, 3);
  frame.depth = DepthImage(192, 144, 1, 2.0F);
  for (int v = 0; v < 144; ++v) {
    for (int u = 0; u < 192; ++u) {
      const bool patch = std::abs(u - color_position) < 20 && std::abs(v - 70) < 40;
      const double light = patch ? 0.03 : 0.1 + 0.2 * static_cast<double>(Random(1, u / 8 + 100 * (v / 8)).uniform());
      const double value = 255 * srgb_of(std::min(1.0, gain * light));
      for (int c = 0; c < 3; ++c) frame.color.at(u, v, c) = static_cast<std::uint8_t>(std::lround(value));
      if (std::abs(u - depth_position) < 20 && std::abs(v - 70) < 40) frame.depth.at(u, v) = 1.5F;
    }
  }
  return frame;
}

double swing(double frame) { return 96 + 50 * std::sin(0.02 * frame * frame); }

TEST(StreamDelay, IsNotToldWhenNothingMoves) {
  StreamDelay delay;
  for (int i = 0; i < 30; ++i) delay.add(frame_of(i, 1, 80, 80));
  EXPECT_FALSE(delay.seconds());
}

TEST(StreamDelay, OfTwoFramesIsFound) {
  StreamDelay delay;
  for (int i = 0; i < 45; ++i) delay.add(frame_of(i, 1, swing(i), swing(i - 2)));
  const auto offset = delay.seconds();
  ASSERT_TRUE(offset);
  EXPECT_NEAR(*offset, 2 / 30.0, 0.4 / 30);
}

TEST(StreamDelay, IsFoundWhileExposureChanges) {
  StreamDelay delay;
  for (int i = 0; i < 45; ++i) delay.add(frame_of(i, 1 + 0.3 * std::sin(2.1 * i), swing(i), swing(i - 2)));
  const auto offset = delay.seconds();
  ASSERT_TRUE(offset);
  EXPECT_NEAR(*offset, 2 / 30.0, 0.4 / 30);
}

TEST(StreamDelay, IsNoneWhereThereIsNone) {
  StreamDelay delay;
  for (int i = 0; i < 45; ++i) delay.add(frame_of(i, 1, swing(i), swing(i)));
  const auto offset = delay.seconds();
  ASSERT_TRUE(offset);
  EXPECT_NEAR(*offset, 0, 0.3 / 30);
}

} // namespace
} // namespace kinora::ingest
