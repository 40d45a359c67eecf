// What is remembered of a pixel's depth: measured, guessed from its neighbours, extended from afar, or not known.
#include <gtest/gtest.h>

#include "core/error.h"
#include "fields/sampling/pixel_store.h"

namespace kinora::fields {
namespace {

constexpr int kWidth = 40;
constexpr int kHole = 10; // columns from here on have no clean depth
constexpr int kFar = 30;  // from here on not even beside them

/// A wall, of which the left part alone is measured.
ingest::Frame wall() {
  ingest::Frame frame;
  frame.camera.intrinsics = {kWidth, 3, 30, 30, 20, 1};
  frame.color = ColorImage(kWidth, 3, 3);
  frame.depth = DepthImage(kWidth, 3);
  for (int v = 0; v < 3; ++v) {
    for (int u = 0; u < kHole; ++u) frame.depth.at(u, v) = 2;
  }
  frame.clean_depth = frame.depth;
  return frame;
}

StoredPixel stored(const ingest::Frame& frame, int u) {
  PixelStore store(1000, 1);
  store.add(frame, 0);
  return store.pixels()[static_cast<std::size_t>(kWidth) + static_cast<std::size_t>(u)]; // all are kept, row by row
}

TEST(StoredDepth, IsMeasuredWhereTheFrameHasCleanDepth) {
  const StoredDepth depth = stored(wall(), kHole - 1).depth;
  EXPECT_TRUE(depth.is_measured() && depth.is_known() && !depth.is_guessed());
  EXPECT_EQ(depth.metres(), 2);
}

TEST(StoredDepth, IsGuessedBesideCleanDepthOfTheSameLabel) {
  ingest::Frame frame = wall();
  EXPECT_TRUE(stored(frame, kHole).depth.is_guessed());
  EXPECT_EQ(stored(frame, kHole).depth.metres(), 2);
  frame.labels = LabelImage(kWidth, 3);
  for (int v = 0; v < 3; ++v) frame.labels.at(kHole, v) = 1;
  EXPECT_FALSE(stored(frame, kHole).depth.is_known()) << "nothing of its own label is near";
  EXPECT_TRUE(stored(frame, kHole + 1).depth.is_guessed());
}

TEST(StoredDepth, IsExtendedFarFromAllCleanDepthOfTheBackground) {
  const StoredDepth depth = stored(wall(), kFar).depth;
  EXPECT_TRUE(depth.is_extended() && depth.is_guessed() && depth.is_known() && !depth.is_measured());
  EXPECT_NEAR(depth.metres(), 2, 1e-3);
  EXPECT_FALSE(stored(wall(), kHole).depth.is_extended());
}

TEST(StoredDepth, IsUnknownFarFromAllCleanDepthOfAThing) {
  ingest::Frame frame = wall();
  frame.labels = LabelImage(kWidth, 3);
  for (int v = 0; v < 3; ++v) frame.labels.at(kFar, v) = 1;
  const StoredDepth depth = stored(frame, kFar).depth;
  EXPECT_FALSE(depth.is_measured() || depth.is_guessed() || depth.is_extended() || depth.is_known());
  EXPECT_EQ(depth.metres(), 0);
}

TEST(PixelStore, OfStoresIsTheStoreOfTheirFrames) {
  ingest::Frame next = wall();
  next.camera.camera_to_world = SE3(Eigen::Translation3d(1, 2, 3));
  next.color.pixel(5, 1)[0] = 77;
  PixelStore direct(1000, 2), first(1000, 1), second(1000, 1), both(1000, 2);
  direct.add(wall(), 4);
  direct.add(next, 7);
  first.add(wall(), 4);
  second.add(next, 7);
  both.add(first);
  both.add(second);
  ASSERT_EQ(both.frames().size(), 2U);
  for (std::size_t f = 0; f < 2; ++f) {
    EXPECT_EQ(both.frames()[f].frame, direct.frames()[f].frame);
    EXPECT_EQ(both.frames()[f].begin, direct.frames()[f].begin);
    EXPECT_EQ(both.frames()[f].end, direct.frames()[f].end);
    EXPECT_TRUE(both.frames()[f].camera.camera_to_world.isApprox(direct.frames()[f].camera.camera_to_world));
  }
  ASSERT_EQ(both.pixels().size(), direct.pixels().size());
  for (std::size_t i = 0; i < both.pixels().size(); ++i) {
    EXPECT_EQ(both.pixels()[i].u, direct.pixels()[i].u);
    EXPECT_EQ(both.pixels()[i].color, direct.pixels()[i].color);
  }
  PixelStore small(100, 1);
  EXPECT_THROW(small.add(first), Error);
}

} // namespace
} // namespace kinora::fields
