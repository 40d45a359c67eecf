// Live encoding of a box that slides before a wall.
#include "encode/live/live_encoder.h"

#include <thread>

#include <gtest/gtest.h>

#include "core/error.h"
#include "encode/live/live_exchange.h"
#include "ingest/capture/frames_capture.h"
#include "tracking/scenes/synthetic_scene.h"

namespace kinora::encode {
namespace {

constexpr int kFrames = 12;

tracking::testing::SceneOptions small_picture() {
  tracking::testing::SceneOptions scene;
  scene.width = 160;
  scene.height = 120;
  scene.focal = 160;
  return scene;
}

std::vector<ingest::Frame> sliding_box() {
  std::vector<ingest::Frame> frames;
  for (int i = 0; i < kFrames; ++i) {
    const SE3 pose = tracking::testing::pose_at({-0.06 + 0.01 * i, 0, 1}, 20, 30);
    frames.push_back(tracking::testing::render_frame({}, pose, SE3::Identity(), i, small_picture()));
  }
  return frames;
}

/// As after Ctrl-C when so many frames have come.
class StoppedCapture final : public ingest::Capture {
public:
  explicit StoppedCapture(int frames) : frames_(frames) {}
  const ingest::CaptureInfo& info() const override { return all_.info(); }
  const std::vector<ingest::SkippedFrame>& skipped() const override { return all_.skipped(); }
  std::optional<ingest::Frame> next() override {
    if (frames_-- == 0) throw Error(ErrorCode::kInterrupted, "stopped");
    return all_.next();
  }

private:
  ingest::testing::FramesCapture all_{sliding_box()};
  int frames_;
};

/// Little work; no waiting.
LiveRequest quick_request() {
  LiveRequest request;
  request.interval = 0;
  request.after_end = 0;
  request.publish = [](const clip::Clip& /*clip*/) {};
  return request;
}

EncodeResult encode(ingest::Capture& capture, const LiveRequest& request) {
  Progress quiet;
  EncodeOptions options = EncodeOptions::of(Preset::kFast);
  options.settings.live.key_frames.capacity = 4;
  options.settings.live.training = {1024, 1024, 512, 2000, 0.1};
  return encode_live(capture, request, options, quiet);
}

ErrorCode code_of_failure(ingest::Capture& capture, const LiveRequest& request) {
  try {
    encode(capture, request);
  } catch (const Error& error) {
    return error.code();
  }
  ADD_FAILURE() << "nothing was thrown";
  return ErrorCode::kFailure;
}

std::vector<std::string> layer_names(const clip::Clip& clip) {
  std::vector<std::string> names;
  for (const clip::Layer& layer : clip.layers) names.push_back(layer.name);
  return names;
}

TEST(LiveEncoder, EndsWithAClipOfAllFramesAndLayers) {
  ingest::testing::FramesCapture capture(sliding_box());
  LiveRequest request = quick_request();
  std::size_t last_frames = 0;
  request.publish = [&](const clip::Clip& clip) {
    EXPECT_GE(clip.times.size(), last_frames); // it grows
    last_frames = clip.times.size();
  };
  const EncodeResult result = encode(capture, request);
  EXPECT_EQ(last_frames, static_cast<std::size_t>(kFrames));
  EXPECT_EQ(result.clip.times.size(), static_cast<std::size_t>(kFrames));
  EXPECT_EQ(layer_names(result.clip), (std::vector<std::string>{"background", "object"}));
  const motion::Motion& box = result.clip.layers[1].motion;
  ASSERT_EQ(box.poses().size(), static_cast<std::size_t>(kFrames));
  EXPECT_NEAR(box.poses().back().canonical_to_world.translation().x(), 0.01 * (kFrames - 1), 0.01);
  EXPECT_EQ(result.report["live"]["frames_followed"], kFrames);
  EXPECT_EQ(result.report["live"]["frames_lost"], 0);
}

TEST(LiveEncoder, StopLeavesAClipUpToThatMoment) {
  StoppedCapture capture(7);
  std::size_t last_frames = 0;
  LiveRequest request = quick_request();
  request.publish = [&](const clip::Clip& clip) { last_frames = clip.times.size(); };
  try {
    const EncodeResult result = encode(capture, request);
    EXPECT_TRUE(result.report["live"]["stopped"].get<bool>());
    EXPECT_EQ(result.clip.times.size(), 7U);
    EXPECT_EQ(last_frames, 7U);
  } catch (const Error& error) { // before any field was begun
    EXPECT_EQ(error.code(), ErrorCode::kInterrupted);
    EXPECT_EQ(last_frames, 0U);
  }
}

TEST(LiveEncoder, WithoutMasksItIsRefused) {
  std::vector<ingest::Frame> frames = sliding_box();
  for (ingest::Frame& frame : frames) frame.labels = {};
  ingest::testing::FramesCapture capture(std::move(frames));
  EXPECT_EQ(code_of_failure(capture, quick_request()), ErrorCode::kUsage);
}

TEST(LiveEncoder, WhatCannotBeWrittenEndsIt) {
  ingest::testing::FramesCapture capture(sliding_box());
  LiveRequest request = quick_request();
  request.publish = [](const clip::Clip& /*clip*/) { throw Error(ErrorCode::kUnwritableOutput, "the disk is full"); };
  EXPECT_EQ(code_of_failure(capture, request), ErrorCode::kUnwritableOutput);
}

TEST(LiveExchange, GivesTheNewestSnapshotToAnotherThreadAndInTheEndTheLastOne) {
  LiveExchange exchange;
  std::size_t seen = 0;
  std::thread trainer([&] {
    std::shared_ptr<const LiveSnapshot> snapshot;
    do {
      snapshot = exchange.newest(snapshot.get());
      EXPECT_GT(snapshot->timeline.times.size(), seen);
      seen = snapshot->timeline.times.size();
    } while (!snapshot->is_last);
  });
  clip::Clip timeline;
  for (int i = 0; i < 100; ++i) {
    timeline.times.push_back(i);
    if (exchange.wants_snapshot() || i == 99) exchange.give({timeline, {}, i == 99});
  }
  trainer.join();
  EXPECT_EQ(seen, 100U);
}

} // namespace
} // namespace kinora::encode
