// Live encoding of a box that slides before a wall.
#include "encode/live/live_encoder.h"

#include <thread>

#include <sys/resource.h>

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
  options.settings.live.training = {1024, 1024, 512, 256, 2000, 0.1};
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

/// Every layer has one finite pose for each frame of the clip.
void expect_whole(const EncodeResult& result, std::size_t frames) {
  EXPECT_EQ(result.clip.times.size(), frames);
  EXPECT_FALSE(result.clip.layers.empty());
  for (const clip::Layer& layer : result.clip.layers) {
    if (layer.motion.kind() == motion::MotionKind::kStill) continue;
    ASSERT_EQ(layer.motion.poses().size(), frames) << layer.name;
    for (const auto& pose : layer.motion.poses())
      EXPECT_TRUE(pose.canonical_to_world.matrix().allFinite()) << layer.name;
  }
}

EncodeResult encode_frames(std::vector<ingest::Frame> frames) {
  ingest::testing::FramesCapture capture(std::move(frames));
  return encode(capture, quick_request());
}

/// Where the box ends, metres from where it began.
double way_of_box(const EncodeResult& result) {
  const motion::Motion& box = result.clip.layers.back().motion;
  return box.poses().back().canonical_to_world.translation().x() -
         box.poses().front().canonical_to_world.translation().x();
}

TEST(LiveEncoder, OneFrameOrTwoAreEnough) {
  for (const std::size_t count : {1, 2}) {
    std::vector<ingest::Frame> frames = sliding_box();
    frames.resize(count);
    expect_whole(encode_frames(std::move(frames)), count);
  }
}

TEST(LiveEncoder, AStillSceneHasStillLayers) {
  const EncodeResult result = encode_frames(std::vector<ingest::Frame>(kFrames, sliding_box().front()));
  expect_whole(result, kFrames);
  for (const clip::Layer& layer : result.clip.layers) EXPECT_EQ(layer.motion.kind(), motion::MotionKind::kStill);
}

TEST(LiveEncoder, FollowsThroughFramesWithoutDepth) {
  std::vector<ingest::Frame> frames = sliding_box();
  for (std::size_t i = 5; i < 8; ++i)
    frames[i].depth = frames[i].clean_depth = DepthImage(frames[i].depth.width(), frames[i].depth.height());
  const EncodeResult result = encode_frames(std::move(frames));
  expect_whole(result, kFrames);
  EXPECT_NEAR(way_of_box(result), 0.01 * (kFrames - 1), 0.01);
}

TEST(LiveEncoder, FollowsWhenTheLightIsDimmedByHalf) {
  std::vector<ingest::Frame> frames = sliding_box();
  for (std::size_t i = 6; i < frames.size(); ++i) {
    ColorImage& color = frames[i].color;
    for (std::size_t k = 0; k < color.values().size(); ++k)
      color.data()[k] = static_cast<std::uint8_t>(color.data()[k] / 2);
  }
  const EncodeResult result = encode_frames(std::move(frames));
  expect_whole(result, kFrames);
  EXPECT_NEAR(way_of_box(result), 0.01 * (kFrames - 1), 0.01);
}

TEST(LiveEncoder, TakesInALayerThatAppearsLateAndOneThatLeaves) {
  for (const bool leaves : {false, true}) {
    SCOPED_TRACE(leaves);
    std::vector<ingest::Frame> frames = sliding_box();
    const ingest::Frame empty = tracking::testing::render_frame(
        {}, tracking::testing::pose_at({0, 0, -1}, 0, 0), SE3::Identity(), 0, small_picture()); // behind the camera
    for (std::size_t i = 0; i < frames.size(); ++i)
      if ((i >= 6) == leaves) frames[i] = empty;
    const EncodeResult result = encode_frames(std::move(frames));
    expect_whole(result, kFrames);
    EXPECT_EQ(layer_names(result.clip), (std::vector<std::string>{"background", "object"}));
    const auto lost = motion::Health::kLost;
    const motion::Motion& box = result.clip.layers.back().motion;
    EXPECT_EQ(box.health(0) == lost, !leaves);
    EXPECT_EQ(box.health(kFrames - 1) != motion::Health::kTracked, leaves);
  }
}

TEST(LiveEncoder, ATrainerThatGetsHardlyAnyTimeGivesAllFramesAndLayers) {
  Progress quiet;
  EncodeOptions options = EncodeOptions::of(Preset::kFast);
  options.settings.live.training = {16, 16, 0, 256, 200, 0.1};
  ingest::testing::FramesCapture capture(sliding_box());
  const EncodeResult result = encode_live(capture, quick_request(), options, quiet);
  expect_whole(result, kFrames);
  EXPECT_EQ(result.clip.layers.size(), 2U);
}

/// A box that goes forth and back, for as long as is wanted.
class LongCapture final : public ingest::Capture {
public:
  explicit LongCapture(int frames) : frames_(frames) {}
  const ingest::CaptureInfo& info() const override { return first_.info(); }
  const std::vector<ingest::SkippedFrame>& skipped() const override { return first_.skipped(); }
  std::optional<ingest::Frame> next() override {
    if (next_ == frames_) return std::nullopt;
    ingest::Frame frame =
        shown_[static_cast<std::size_t>(next_ / kFrames % 2 == 0 ? next_ % kFrames : kFrames - 1 - next_ % kFrames)];
    frame.index = next_;
    frame.time = next_ / 30.0;
    ++next_;
    return frame;
  }

private:
  static std::vector<ingest::Frame> small_frames() {
    tracking::testing::SceneOptions scene;
    scene.width = 64;
    scene.height = 48;
    scene.focal = 64;
    std::vector<ingest::Frame> frames;
    for (int i = 0; i < kFrames; ++i) {
      const SE3 pose = tracking::testing::pose_at({-0.06 + 0.01 * i, 0, 1}, 20, 30);
      frames.push_back(tracking::testing::render_frame({}, pose, SE3::Identity(), i, scene));
    }
    return frames;
  }
  std::vector<ingest::Frame> shown_ = small_frames();
  ingest::testing::FramesCapture first_{{shown_.front()},
                                        {{2, {"box", "rigid", ""}}}}; // else the past is remembered, in 200 MB
  int frames_;
  int next_ = 0;
};

TEST(LiveEncoder, OfALongCaptureOnlyTheMotionIsRemembered) {
  std::vector<std::size_t> kilobytes; // at most, in either run
  for (const int frames : {500, 3000}) {
    LongCapture capture(frames);
    expect_whole(encode(capture, quick_request()), static_cast<std::size_t>(frames));
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    kilobytes.push_back(static_cast<std::size_t>(usage.ru_maxrss));
  }
  EXPECT_LT(kilobytes[1], kilobytes[0] + 12 * 2500); // a frame has 37 kB
}

TEST(LiveEncoder, WithoutMasksWhatWasWatchedTellsWhatMoves) {
  std::vector<ingest::Frame> frames = sliding_box();
  for (ingest::Frame& frame : frames) frame.labels = {};
  const EncodeResult result = encode_frames(std::move(frames));
  expect_whole(result, kFrames); // it ended before enough was seen, and came whole
  EXPECT_EQ(result.report["config"]["labels_from"], "motion");
  EXPECT_FALSE(result.report["capture"]["has_masks"].get<bool>());
  EXPECT_EQ(layer_names(result.clip).front(), "background");
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
