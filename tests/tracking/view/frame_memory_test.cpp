#include "tracking/view/frame_memory.h"

#include <gtest/gtest.h>

#include "tracking/scenes/bending_plate.h"

namespace kinora::tracking {
namespace {

using testing::render_plate;

TEST(FrameMemory, GivesBackWhatTheViewShows) {
  const ingest::Frame frame = render_plate({}, testing::pose_at({0, 0, -1}, 0, 0), 0);
  FrameMemory memory;
  memory.add(frame, view_object(frame, 2));
  ASSERT_EQ(memory.begin(), 0U);
  const ObjectView before = view_object(frame, 2);
  const ObjectView after = view_object(memory.at(0), 2);
  EXPECT_EQ(after.depth_pixels, before.depth_pixels);
  EXPECT_LT((after.centroid - before.centroid).norm(), 1e-9);
  const Eigen::Vector2d pixel = before.intrinsics.project(before.centroid);
  const Eigen::Vector2d same = after.intrinsics.project(after.centroid);
  EXPECT_EQ(before.sample_texture(0, pixel.x(), pixel.y()).value, after.sample_texture(0, same.x(), same.y()).value);
}

TEST(FrameMemory, ForgetsTheOldestBeyond200Megabytes) {
  testing::SceneOptions options;
  options.width = 1280;
  options.height = 960;
  options.focal = 1280;
  const ingest::Frame frame = render_plate({}, testing::pose_at({0, 0, -0.6}, 0, 0), 0, options);
  const ObjectView view = view_object(frame, 2);
  const auto bytes = 8.0 * view.intrinsics.width * view.intrinsics.height;
  FrameMemory memory;
  for (int i = 0; i < 30; ++i) memory.add(frame, view);
  EXPECT_EQ(memory.count(), 30U);
  EXPECT_EQ(memory.count() - memory.begin(), static_cast<std::size_t>(2e8 / bytes));
}

TEST(FrameMemory, CountsFramesThatShowNothing) {
  const ingest::Frame frame = render_plate({}, testing::pose_at({0, 0, -1}, 0, 0), 0);
  FrameMemory memory;
  memory.add(frame, {});
  EXPECT_EQ(memory.count(), 1U);
  EXPECT_TRUE(memory.at(0).color.empty());
}

} // namespace
} // namespace kinora::tracking
