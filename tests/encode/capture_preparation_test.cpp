#include "encode/capture_preparation.h"

#include <gtest/gtest.h>

#include "tracking/scenes/room_scene.h"

namespace kinora::encode {
namespace {

using tracking::testing::pose_at;

constexpr int kFrames = 36;
constexpr double kRange = 2.4; // metres: the walls ahead are farther

/// A phone looks down a little, goes 20 cm to and fro and turns.
SE3 phone(int i) {
  return pose_at({0.2 * std::sin(0.12 * i), 0.03 * std::sin(0.2 * i), 0}, -22 + 2 * std::sin(0.1 * i),
                 4 * std::sin(0.15 * i), 0);
}

/// A box that fills much of the picture and goes its own way, before walls that are out of range.
class MovingCameraRoom final : public ingest::Capture {
public:
  explicit MovingCameraRoom(const FrameRange& range) : range_(range), next_(range.begin) {
    info_.frame_count = kFrames;
    info_.intrinsics = frame(0).camera.intrinsics;
  }
  const ingest::CaptureInfo& info() const override { return info_; }
  const std::vector<ingest::SkippedFrame>& skipped() const override { return skipped_; }
  std::optional<ingest::Frame> next() override {
    if (next_ >= kFrames || !range_.contains(next_)) return std::nullopt;
    ingest::Frame result = frame(next_);
    result.labels = {};
    next_ += range_.step;
    return result;
  }
  /// With labels.
  static ingest::Frame frame(int i) {
    tracking::testing::RoomOptions options;
    options.furnished = false;
    options.mover_has_label = true;
    options.mover = pose_at({-0.3 + 0.02 * i, 0.25 + 0.1 * std::sin(0.3 * i), 1.3}, 3.0 * i, 20, 0);
    ingest::Frame frame = tracking::testing::render_room(phone(i), i, options);
    frame.camera.camera_to_world = SE3::Identity();
    for (float& z : frame.depth.values())
      if (z > kRange) z = 0;
    frame.clean_depth = frame.depth;
    return frame;
  }

private:
  FrameRange range_;
  int next_;
  ingest::CaptureInfo info_;
  std::vector<ingest::SkippedFrame> skipped_;
};

TEST(CapturePreparation, FollowsTheFloorAndNotWhatMovesWhereWallsAreOutOfRange) {
  Progress progress;
  CaptureRequest request;
  request.open = [](const ingest::CaptureOptions& how, Progress& /*progress*/) {
    return std::make_unique<MovingCameraRoom>(how.frames);
  };
  const PreparedCapture prepared = prepare_capture(request, progress);
  ASSERT_TRUE(prepared.camera->moves());
  double both = 0;
  double either = 0;
  while (const auto frame = prepared.capture->next()) {
    const SE3 truth = phone(0).inverse() * phone(frame->index);
    const SE3 off = truth.inverse() * frame->camera.camera_to_world;
    EXPECT_LT(off.translation().norm(), 0.03) << frame->index;
    EXPECT_LT(rotation_angle(off), 0.02) << frame->index;
    const LabelImage mask = MovingCameraRoom::frame(frame->index).labels;
    for (std::size_t i = 0; i < mask.pixel_count(); ++i) {
      both += mask.data()[i] != 0 && frame->labels.data()[i] != 0 ? 1 : 0;
      either += mask.data()[i] != 0 || frame->labels.data()[i] != 0 ? 1 : 0;
    }
  }
  EXPECT_GT(both, 0.8 * either);
}

} // namespace
} // namespace kinora::encode
