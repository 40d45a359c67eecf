// Colour that is finer than what the depth camera measures: neighbouring pixels share one measurement and its noise.
#include "encode/scene_tracker.h"

#include <gtest/gtest.h>

#include "tracking/scenes/synthetic_scene.h"

namespace kinora::encode {
namespace {

using tracking::testing::Shape;

constexpr int kFrames = 8;
const Shape kBox;

SE3 box_at(int frame, double distance = 1.6) {
  return tracking::testing::pose_at({0.02 * frame, 0, distance}, 20 + 2.0 * frame, 3.0 * frame);
}

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

/// Poses of the box in frames that `frame_at` gives.
template <class FrameAt> std::vector<motion::Motion::Pose> follow(const FrameAt& frame_at) {
  ingest::CaptureInfo capture;
  capture.labels[2] = {"box", "rigid", ""};
  Progress progress;
  StageTimes times;
  SceneTracker scene(capture, {}, progress);
  for (int i = 0; i < kFrames; ++i) scene.add(frame_at(i), times);
  return std::move(scene).finish(times).at(2).poses;
}

double error(const motion::Motion::Pose& pose, int frame, double distance = 1.6) {
  const SE3 first = box_at(0, distance);
  return (pose.canonical_to_world * first.translation() - box_at(frame, distance).translation()).norm();
}

class SceneTrackerOfFineColour : public ::testing::TestWithParam<int> {};

TEST_P(SceneTrackerOfFineColour, FollowsAThingAsItDoesAtTheSizeOfTheDepth) {
  const auto poses = follow([](int i) { return frame_at(i, GetParam()); });
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_EQ(poses.at(static_cast<std::size_t>(i)).health, motion::Health::kTracked) << i;
    EXPECT_LT(error(poses.at(static_cast<std::size_t>(i)), i), 0.004) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, SceneTrackerOfFineColour, ::testing::Values(1, 2, 4));

TEST(SceneTracker, FollowsAThingOfAHundredAndTwentyPixels) {
  constexpr double kDistance = 2.4;
  constexpr double kFootprint = 0.018; // metres, of a pixel there
  tracking::testing::SceneOptions options;
  options.width = 160;
  options.height = 120;
  options.focal = 131;
  options.noise = 1;
  const auto poses = follow([&](int i) {
    options.seed = 5 + static_cast<std::uint64_t>(i);
    return render_frame(kBox, box_at(i, kDistance), SE3::Identity(), i, options);
  });
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_EQ(poses.at(static_cast<std::size_t>(i)).health, motion::Health::kTracked) << i;
    EXPECT_LT(error(poses.at(static_cast<std::size_t>(i)), i, kDistance), kFootprint) << i;
  }
}

} // namespace
} // namespace kinora::encode
