#include "tracking/view/frame_history.h"

#include <gtest/gtest.h>

#include "tracking/scenes/bending_plate.h"

namespace kinora::tracking {
namespace {

using testing::render_plate;

TEST(FrameHistory, GivesBackWhatTheViewShows) {
  const ingest::Frame frame = render_plate({}, testing::pose_at({0, 0, -1}, 0, 0), 0);
  FrameHistory history;
  history.add(frame, view_label(frame, 2));
  ASSERT_EQ(history.begin(), 0U);
  const LayerView before = view_label(frame, 2);
  const LayerView after = view_label(history.at(0), 2);
  EXPECT_EQ(after.depth_pixels, before.depth_pixels);
  EXPECT_LT((after.centroid - before.centroid).norm(), 1e-9);
  const Eigen::Vector2d pixel = before.intrinsics.project(before.centroid);
  const Eigen::Vector2d same = after.intrinsics.project(after.centroid);
  EXPECT_EQ(before.sample_texture(0, pixel.x(), pixel.y()).value, after.sample_texture(0, same.x(), same.y()).value);
}

TEST(FrameHistory, ForgetsTheOldestBeyond200Megabytes) {
  testing::SceneOptions options;
  options.width = 1280;
  options.height = 960;
  options.focal = 1280;
  const ingest::Frame frame = render_plate({}, testing::pose_at({0, 0, -0.6}, 0, 0), 0, options);
  const LayerView view = view_label(frame, 2);
  const auto bytes = 8.0 * view.intrinsics.width * view.intrinsics.height;
  FrameHistory history;
  for (int i = 0; i < 30; ++i) history.add(frame, view);
  EXPECT_EQ(history.count(), 30U);
  EXPECT_EQ(history.count() - history.begin(), static_cast<std::size_t>(2e8 / bytes));
}

TEST(FrameHistory, CountsFramesThatShowNothing) {
  const ingest::Frame frame = render_plate({}, testing::pose_at({0, 0, -1}, 0, 0), 0);
  FrameHistory history;
  history.add(frame, {});
  EXPECT_EQ(history.count(), 1U);
  EXPECT_TRUE(history.at(0).color.empty());
}

} // namespace
} // namespace kinora::tracking
