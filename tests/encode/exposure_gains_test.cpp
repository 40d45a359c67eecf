// Exposure and white balance that change while a camera moves past a wall, with somebody before it.
#include "encode/exposure_gains.h"

#include <cmath>

#include <gtest/gtest.h>

namespace kinora::encode {
namespace {

constexpr int kFrames = 12;
constexpr int kWidth = 80, kHeight = 60;
constexpr int kFirst = 5; ///< number of the first frame in the capture

using GainOf = ColorGain (*)(int frame);

ColorGain none(int /*frame*/) { return {}; }
ColorGain alternating(int frame) {
  return frame % 2 == 0 ? ColorGain{{0.7F, 0.7F, 0.7F}} : ColorGain{{1.2F, 1.2F, 1.2F}};
}
ColorGain drifting(int frame) {
  const float at = static_cast<float>(frame) / kFrames;
  return {{1 + at, 1, 1 - 0.4F * at}};
}

ingest::Frame picture(int index, double step, const ColorGain& gain) {
  ingest::Frame frame;
  frame.color = ColorImage(kWidth, kHeight, 3);
  frame.depth = DepthImage(kWidth, kHeight, 1, 2);
  frame.labels = LabelImage(kWidth, kHeight);
  frame.camera.intrinsics = {kWidth, kHeight, 60, 60, 39.5, 29.5};
  frame.camera.camera_to_world.translation().x() = step * index;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double x = (u - 39.5) / 30 + step * index;
      const double y = (v - 29.5) / 30;
      frame.color.at(u, v, 0) = static_cast<std::uint8_t>(110 + 50 * std::sin(3 * x + y));
      frame.color.at(u, v, 1) = static_cast<std::uint8_t>(100 + 40 * std::sin(2 * x - 3 * y));
      frame.color.at(u, v, 2) = static_cast<std::uint8_t>(120 + 60 * std::cos(4 * x));
      if (u < 25) { // somebody whose clothes change colour as he likes
        frame.labels.at(u, v) = 1;
        frame.color.at(u, v, 0) = static_cast<std::uint8_t>(20 * index);
      }
    }
  }
  GainTables(gain).apply_to(frame.color);
  frame.clean_depth = frame.depth;
  return frame;
}

FramePass pass_with(GainOf gain, double step) {
  FramePass pass{{}, fields::PixelStore(kFrames * kWidth * kHeight, kFrames), {}, {}, 0};
  for (int f = 0; f < kFrames; ++f) {
    pass.pixels.add(picture(f, step, gain(f)), f);
    pass.clip.capture_frames.push_back(kFirst + f);
  }
  return pass;
}

/// By the largest factor that any colour of any frame is off, once both have a geometric mean of 1.
double error_of(const clip::Exposure& found, GainOf truth) {
  double largest = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    double mean = 0;
    for (int f = 0; f < kFrames; ++f) mean += std::log(truth(f).factors[c]) / kFrames;
    for (int f = 0; f < kFrames; ++f) {
      const double expected = std::log(truth(f).factors[c]) - mean;
      largest = std::max(largest, std::abs(std::log(found.at(kFirst + f).factors[c]) - expected));
    }
  }
  return largest;
}

TEST(MeasureExposure, FindsWhatAlternatesAndWhatDriftsForStillAndMovingCameras) {
  for (const GainOf truth : {alternating, drifting}) {
    for (const double step : {0.0, 0.03}) {
      const clip::Exposure found = measure_exposure(pass_with(truth, step));
      ASSERT_EQ(found.size(), static_cast<std::size_t>(kFrames)) << step;
      EXPECT_LT(error_of(found, truth), 0.015) << step;
    }
  }
}

TEST(MeasureExposure, OfEvenFramesIsNothing) {
  EXPECT_TRUE(measure_exposure(pass_with(none, 0)).empty());
  EXPECT_TRUE(measure_exposure(pass_with(none, 0.03)).empty()) << "other parts of the wall are no other exposure";
}

TEST(MeasureExposure, FramesThatHaveNothingInCommonTellNothing) {
  EXPECT_TRUE(measure_exposure(pass_with(alternating, 10)).empty());
  EXPECT_TRUE(measure_exposure({{}, fields::PixelStore(10, 1), {}, {}, 0}).empty());
}

TEST(TakeOut, LeavesFramesAsIfExposureHadBeenEven) {
  FramePass pass = pass_with(alternating, 0);
  const FramePass even = pass_with(none, 0);
  take_out(measure_exposure(pass), pass);
  const double mean = std::sqrt(0.7 * 1.2); // of the gains
  const GainTables dimmed{ColorGain{{static_cast<float>(mean), static_cast<float>(mean), static_cast<float>(mean)}}};
  double difference = 0;
  for (std::size_t i = 0; i < pass.pixels.pixels().size(); ++i) {
    const fields::StoredPixel& pixel = pass.pixels.pixels()[i];
    if (pixel.label != 0) continue;
    const auto wanted = dimmed(even.pixels.pixels()[i].color);
    for (std::size_t c = 0; c < 3; ++c) difference = std::max(difference, std::abs(pixel.color[c] - wanted[c]) * 1.0);
  }
  EXPECT_LE(difference, 4);
}

} // namespace
} // namespace kinora::encode
