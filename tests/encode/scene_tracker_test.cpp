// Colour that is finer than what the depth camera measures: neighbouring pixels share one measurement and its noise.
#include "encode/scene_tracker.h"

#include <gtest/gtest.h>

#include "tracking/scenes/synthetic_scene.h"

namespace kinora::encode {
namespace {

using tracking::testing::Shape;

constexpr int kFrames = 8;
const Shape kBox;

SE3 box_at(int frame) { return tracking::testing::pose_at({0.02 * frame, 0, 1.6}, 20 + 2.0 * frame, 3.0 * frame); }

/// Each pixel becomes `factor` × `factor` like it.
template <class Pixels> Pixels enlarged(const Pixels& image, int factor) {
  Pixels result(factor * image.width(), factor * image.height(), image.channels());
  for (int v = 0; v < result.height(); ++v)
    for (int u = 0; u < result.width(); ++u)
      for (int c = 0; c < image.channels(); ++c) result.at(u, v, c) = image.at(u / factor, v / factor, c);
  return result;
}

ingest::Frame frame_at(int index, int factor) {
  tracking::testing::SceneOptions options;
  options.width = 480;
  options.height = 360;
  options.focal = 420;
  options.noise = 1;
  options.seed = 5 + static_cast<std::uint64_t>(index);
  ingest::Frame frame = render_frame(kBox, box_at(index), SE3::Identity(), index, options);
  frame.camera.intrinsics = frame.camera.intrinsics.resized(factor * options.width, factor * options.height);
  frame.color = enlarged(frame.color, factor);
  frame.depth = enlarged(frame.depth, factor);
  frame.clean_depth = enlarged(frame.clean_depth, factor);
  frame.labels = enlarged(frame.labels, factor);
  return frame;
}

class SceneTrackerOfFineColour : public ::testing::TestWithParam<int> {};

TEST_P(SceneTrackerOfFineColour, FollowsAThingAsItDoesAtTheSizeOfTheDepth) {
  ingest::CaptureInfo capture;
  capture.labels[2] = {"box", "rigid", ""};
  Progress progress;
  StageTimes times;
  SceneTracker scene(capture, {}, progress);
  for (int i = 0; i < kFrames; ++i) scene.add(frame_at(i, GetParam()), times);
  const std::vector<motion::Motion::Pose> poses = std::move(scene).finish(times).at(2).poses;
  const SE3 first = box_at(0);
  for (int i = 0; i < kFrames; ++i) {
    const motion::Motion::Pose& pose = poses[static_cast<std::size_t>(i)];
    EXPECT_EQ(pose.health, motion::Health::kTracked) << i;
    EXPECT_LT((pose.canonical_to_world * first.translation() - box_at(i).translation()).norm(), 0.004) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, SceneTrackerOfFineColour, ::testing::Values(1, 2, 4));

} // namespace
} // namespace kinora::encode
