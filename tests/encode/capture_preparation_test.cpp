#include "encode/capture_preparation.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/statistics.h"
#include "tracking/scenes/room_scene.h"

namespace kinora::encode {
namespace {

using tracking::testing::pose_at;

constexpr double kRange = 2.4; // metres: the walls ahead are farther

/// A phone looks down a little, goes 20 cm to and fro and turns. Time in frames.
SE3 phone(double i) {
  return pose_at({0.2 * std::sin(0.12 * i), 0.03 * std::sin(0.2 * i), 0}, -22 + 2 * std::sin(0.1 * i),
                 4 * std::sin(0.15 * i), 0);
}

using Frames = std::vector<ingest::Frame>;

/// Without their labels.
class RenderedCapture final : public ingest::Capture {
public:
  RenderedCapture(const Frames& frames, const FrameRange& range) : frames_(frames), range_(range), next_(range.begin) {
    info_.frame_count = static_cast<int>(frames.size());
    info_.intrinsics = frames.front().camera.intrinsics;
  }
  const ingest::CaptureInfo& info() const override { return info_; }
  const std::vector<ingest::SkippedFrame>& skipped() const override { return skipped_; }
  std::optional<ingest::Frame> next() override {
    if (next_ >= info_.frame_count || !range_.contains(next_)) return std::nullopt;
    ingest::Frame frame = frames_[static_cast<std::size_t>(next_)];
    frame.labels = {};
    frame.camera.camera_to_world = SE3::Identity();
    next_ += range_.step;
    return frame;
  }

private:
  const Frames& frames_;
  FrameRange range_;
  int next_;
  ingest::CaptureInfo info_;
  std::vector<ingest::SkippedFrame> skipped_;
};

Frames rendered(int count, ingest::Frame (*render)(int)) {
  Frames frames;
  for (int i = 0; i < count; ++i) frames.push_back(render(i));
  return frames;
}

/// The frames must outlive it.
CaptureRequest request_of(const Frames& frames) {
  CaptureRequest request;
  request.open = [&frames](const ingest::CaptureOptions& how, Progress& /*progress*/) {
    return std::make_unique<RenderedCapture>(frames, how.frames);
  };
  return request;
}

/// A box that fills much of the picture and goes its own way, before walls that are out of range; with labels.
ingest::Frame box_on_its_way(int i) {
  tracking::testing::RoomOptions options;
  options.furnished = false;
  options.mover_has_label = true;
  options.mover = pose_at({-0.3 + 0.02 * i, 0.25 + 0.1 * std::sin(0.3 * i), 1.3}, 3.0 * i, 20, 0);
  ingest::Frame frame = tracking::testing::render_room(phone(i), i, options);
  for (float& z : frame.depth.values())
    if (z > kRange) z = 0;
  frame.clean_depth = frame.depth;
  return frame;
}

TEST(CapturePreparation, FollowsTheFloorAndNotWhatMovesWhereWallsAreOutOfRange) {
  Progress progress;
  const Frames frames = rendered(36, box_on_its_way);
  const PreparedCapture prepared = prepare_capture(request_of(frames), progress);
  ASSERT_TRUE(prepared.camera->moves());
  double both = 0;
  double either = 0;
  while (const auto frame = prepared.capture->next()) {
    const SE3 truth = phone(0).inverse() * phone(frame->index);
    const SE3 off = truth.inverse() * frame->camera.camera_to_world;
    EXPECT_LT(off.translation().norm(), 0.03) << frame->index;
    EXPECT_LT(rotation_angle(off), 0.02) << frame->index;
    const LabelImage mask = frames[static_cast<std::size_t>(frame->index)].labels;
    for (std::size_t i = 0; i < mask.pixel_count(); ++i) {
      both += mask.data()[i] != 0 && frame->labels.data()[i] != 0 ? 1 : 0;
      either += mask.data()[i] != 0 || frame->labels.data()[i] != 0 ? 1 : 0;
    }
  }
  EXPECT_GT(both, 0.8 * either);
}

constexpr double kLagFrames = 0.6;

/// The empty room, whose depth is of a little before.
ingest::Frame late_depth(int i) {
  ingest::Frame frame = tracking::testing::render_room(phone(i), i);
  const ingest::Frame before = tracking::testing::render_room(phone(i - kLagFrames), i);
  frame.depth = before.depth;
  frame.clean_depth = before.clean_depth;
  return frame;
}

bool repeats_depth(int i) { return i % 6 == 5; }
bool repeats_all(int i) { return i % 6 == 2; }

/// The room before a sensor that measures depth less often than colour.
ingest::Frame repeated_depth(int i) {
  if (repeats_all(i)) {
    ingest::Frame frame = repeated_depth(i - 1);
    frame.index = i;
    frame.time = i / 30.0;
    return frame;
  }
  ingest::Frame frame = tracking::testing::render_room(phone(i), i);
  if (!repeats_depth(i)) return frame;
  const ingest::Frame before = tracking::testing::render_room(phone(i - 1), i - 1);
  frame.depth = before.depth;
  frame.clean_depth = before.clean_depth;
  return frame;
}

double median_error(const DepthImage& depth, const DepthImage& truth) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < truth.pixel_count(); ++i) {
    if (depth.data()[i] > 0 && truth.data()[i] > 0) errors.push_back(std::abs(depth.data()[i] - truth.data()[i]));
  }
  return median(errors);
}

double depth_error(const ingest::Frame& frame) {
  tracking::testing::RoomOptions exact;
  exact.noise = 0;
  return median_error(frame.depth, tracking::testing::render_room(phone(frame.index), frame.index, exact).depth);
}

TEST(CapturePreparation, DepthThatRepeatsIsCarriedToItsColour) {
  Progress progress;
  const Frames frames = rendered(36, repeated_depth);
  const PreparedCapture prepared = prepare_capture(request_of(frames), progress);
  ASSERT_TRUE(prepared.camera->moves());
  double repeated = 0, carried = 0;
  while (const auto frame = prepared.capture->next()) {
    const ingest::Frame& raw = frames[static_cast<std::size_t>(frame->index)];
    if (!repeats_depth(frame->index)) {
      EXPECT_TRUE(std::ranges::equal(frame->depth.values(), raw.depth.values())) << frame->index;
      continue;
    }
    repeated += depth_error(raw);
    carried += depth_error(*frame);
  }
  EXPECT_LT(carried, 0.6 * repeated);
}

TEST(CapturePreparation, DepthThatComesLateIsCarriedToItsColour) {
  Progress progress;
  const Frames frames = rendered(90, late_depth);
  CaptureRequest request = request_of(frames);
  request.holdout = 10;
  const PreparedCapture prepared = prepare_capture(request, progress);
  EXPECT_NEAR(prepared.camera->depth_lag, kLagFrames / 30, 0.003);
  double late = 0, carried = 0, held_out = 0;
  for (const ingest::Frame& frame : frames) late += depth_error(frame) / 90;
  while (const auto frame = prepared.capture->next()) carried += depth_error(*frame) / 81;
  while (const auto frame = prepared.held_out->next()) held_out += depth_error(*frame) / 9;
  EXPECT_LT(carried, 0.6 * late);
  EXPECT_LT(held_out, 0.6 * late);
}

} // namespace
} // namespace kinora::encode
