// Which frames of a capture a clip is compared with, and in which group they count.
#include "evaluate/evaluate.h"

#include <gtest/gtest.h>

#include "clip/sample_clip.h"
#include "core/error.h"
#include "ingest/capture/frames_capture.h"

namespace kinora::evaluate {
namespace {

constexpr int kWidth = 24;
constexpr int kHeight = 18;
constexpr int kFrames = 40;

/// Frame i has the grey level 2 i.
std::vector<ingest::Frame> frames_by_number() {
  std::vector<ingest::Frame> frames;
  for (int i = 0; i < kFrames; ++i) {
    ingest::Frame& frame = frames.emplace_back();
    frame.camera.intrinsics = {kWidth, kHeight, 20, 20, 11.5, 8.5};
    frame.color = ColorImage(kWidth, kHeight, 3, static_cast<std::uint8_t>(2 * i));
    frame.depth = DepthImage(kWidth, kHeight, 1, 1.0F);
    frame.labels = LabelImage(kWidth, kHeight);
  }
  return frames;
}

/// A clip of every frame that shows nothing, so that its error is the frames' own grey; every fourth is held out.
player::Player black_clip() {
  clip::Clip clip = clip::testing::sample_clip(1, kFrames, false);
  clip.layers.resize(1);
  clip.layers[0].field.occupancy = fields::Occupancy(clip.layers[0].field.config.occupancy_resolution);
  clip.layers[0].confidence.reset();
  clip.intrinsics = {kWidth, kHeight, 20, 20, 11.5, 8.5};
  for (int i = 0; i < kFrames; ++i) {
    clip.capture_frames[static_cast<std::size_t>(i)] = i;
    clip.held_out[static_cast<std::size_t>(i)] = i % 4 == 3;
  }
  return player::Player(std::move(clip));
}

nlohmann::json compared(const EvaluateOptions& options) {
  ingest::testing::FramesCapture capture(frames_by_number());
  Progress progress;
  return evaluate(black_clip(), capture, nullptr, options, progress);
}

double mean_of(const std::vector<int>& frames) {
  double sum = 0;
  for (const int frame : frames) sum += 2.0 * frame;
  return sum / static_cast<double>(frames.size());
}

TEST(Evaluate, ComparesEveryFrameWithinItsGroup) {
  const nlohmann::json report = compared({});
  EXPECT_EQ(report.at("frames_compared"), kFrames);
  std::vector<int> held_out;
  std::vector<int> trained;
  for (int i = 0; i < kFrames; ++i) (i % 4 == 3 ? held_out : trained).push_back(i);
  const nlohmann::json& layer = report.at("layers").at(0);
  EXPECT_EQ(layer.at("held_out").at("frames"), held_out.size());
  EXPECT_EQ(layer.at("trained").at("frames"), trained.size());
  EXPECT_NEAR(layer.at("held_out").at("mae").get<double>(), mean_of(held_out), 1e-3);
  EXPECT_NEAR(layer.at("trained").at("mae").get<double>(), mean_of(trained), 1e-3);
}

TEST(Evaluate, OfAFewTrainedFramesTheyAreSpreadEvenlyOverTheClipAndAllHeldOutOnesAreCompared) {
  EvaluateOptions options;
  options.max_trained_frames = 5;
  const nlohmann::json layer = compared(options).at("layers").at(0);
  EXPECT_EQ(layer.at("held_out").at("frames"), kFrames / 4);
  EXPECT_EQ(layer.at("trained").at("frames"), 5);
  EXPECT_NEAR(layer.at("trained").at("mae").get<double>(), mean_of({4, 12, 20, 28, 36}), 1e-3);
}

TEST(Evaluate, TellsHowMuchBetterTrainedFramesAreThanHeldOutOnes) {
  const nlohmann::json layer = compared({}).at("layers").at(0);
  EXPECT_NEAR(layer.at("trained_minus_held_out_db").get<double>(),
              layer.at("trained").at("psnr").get<double>() - layer.at("held_out").at("psnr").get<double>(), 2e-4);
  EXPECT_GT(layer.at("trained_minus_held_out_db").get<double>(), 0) << "trained frames are the darker ones here";
}

TEST(Evaluate, AnotherCaptureIsRefused) {
  std::vector<ingest::Frame> frames = frames_by_number();
  for (ingest::Frame& frame : frames) frame.camera.intrinsics.width = kWidth + 1;
  ingest::testing::FramesCapture capture(frames);
  Progress progress;
  EXPECT_THROW((void)evaluate(black_clip(), capture, nullptr, {}, progress), Error);
}

} // namespace
} // namespace kinora::evaluate
