// What the pass over a capture's frames hands on from what it is given.
#include "encode/frame_pass.h"

#include <cmath>

#include <gtest/gtest.h>

#include "ingest/capture/frames_capture.h"
#include "tracking/body/synthetic_body.h"

namespace kinora::encode {
namespace {

constexpr int kFrames = 12;

/// Somebody with short thighs, of whom a table hides what is below the hips, turns.
tracking::BodyState person_at(int frame) {
  tracking::BodyState state = tracking::testing::standing(3.0 * frame);
  state.shape[tracking::kThighLength] = -0.12;
  return state;
}

ingest::testing::FramesCapture person_behind_a_table() {
  std::vector<ingest::Frame> frames;
  for (int i = 0; i < kFrames; ++i) {
    tracking::testing::BodyScene scene;
    scene.seed = static_cast<std::uint64_t>(i);
    scene.cover = tracking::testing::Cover{0, 105, scene.width, scene.height};
    frames.push_back(render_body(person_at(i), scene));
  }
  return ingest::testing::FramesCapture(std::move(frames));
}

FramePass pass_with(const EncodeOptions& options) {
  ingest::testing::FramesCapture capture = person_behind_a_table();
  StageTimes times;
  Progress progress;
  return pass_over_frames(capture, options, times, progress);
}

double thigh_in(const FramePass& pass) {
  const auto joints = pass.labels.at(1).joints();
  if (!joints) return 0;
  const auto& last = joints->positions.back();
  return (last[tracking::kLeftKnee] - last[tracking::kLeftHip]).norm();
}

TEST(FramePass, BeginsWithTheMeasuresThatAreToldOfThePerson) {
  const tracking::Bones bones = forward_kinematics(person_at(0).pose, person_at(0).shape);
  const double truth = (bones[tracking::kLeftKnee].translation() - bones[tracking::kLeftHip].translation()).norm();
  EncodeOptions options = EncodeOptions::of(Preset::kFast);
  const double untold = thigh_in(pass_with(options));
  EXPECT_GT(untold, truth + 0.02) << "nobody tells, and nobody sees";
  options.body.emplace();
  options.body->state.shape = person_at(0).shape;
  options.body->shape_precision.diagonal().setConstant(1 / (0.01 * 0.01));
  const double told = thigh_in(pass_with(options));
  EXPECT_LT(std::abs(told - truth), 0.6 * (untold - truth)) << told << " of " << truth << ", untold " << untold;
}

TEST(FramePass, KeepsPixelsOfAllFramesButThoseThatAreOnlyTracked) {
  EncodeOptions options = EncodeOptions::of(Preset::kFast);
  EXPECT_EQ(pass_with(options).pixels.frames().size(), std::size_t{kFrames});
  options.holdout_tracked = 4;
  const FramePass pass = pass_with(options);
  EXPECT_EQ(pass.clip.times.size(), std::size_t{kFrames});
  ASSERT_EQ(pass.pixels.frames().size(), std::size_t{9});
  for (const fields::StoredFrame& frame : pass.pixels.frames()) {
    EXPECT_NE(frame.frame % 4, 3);
    EXPECT_FALSE(pass.clip.held_out[static_cast<std::size_t>(frame.frame)]);
  }
}

} // namespace
} // namespace kinora::encode
