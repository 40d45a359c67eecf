// Depth of one moment, carried to rows that are read one after the other.
#include "fields/sampling/row_depth.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "fields/scenes/analytic_scene.h"

namespace kinora::fields {
namespace {

constexpr int kFrames = 3;

/// A ball before a wall, from a camera that moves while its rows are read, or (not row by row) that reads all at once
/// in the middle of that time.
PixelStore store_of(bool row_by_row, const std::vector<Twist>& motion, std::size_t max_pixels = 1'000'000) {
  PixelStore store(max_pixels, kFrames);
  const Scene scene;
  for (int f = 0; f < kFrames; ++f) {
    ingest::Frame frame = scene.frame(f, 0.1 * (f - 1));
    const SE3 middle = frame.camera.camera_to_world;
    for (int v = 0; row_by_row && v < kHeight; ++v) {
      ingest::Frame row = frame;
      row.camera.camera_to_world = middle * exp_se3(row_time(v, kHeight) * motion[static_cast<std::size_t>(f)]);
      scene.shade(row);
      for (int u = 0; u < kWidth; ++u) frame.depth.at(u, v) = row.depth.at(u, v);
    }
    frame.clean_depth = frame.depth;
    frame.labels = {};
    store.add(frame, f);
  }
  return store;
}

double mean_difference(const PixelStore& a, const PixelStore& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    sum += std::abs(static_cast<double>(a.pixels()[i].depth.metres() - b.pixels()[i].depth.metres()));
  }
  return sum / static_cast<double>(a.pixels().size());
}

const std::vector<Twist> kMotion = {(Twist() << 0.2, 0, 0.1, 0, 0.1, 0).finished(),
                                    (Twist() << 0, 0.1, -0.2, 0.1, 0, 0.2).finished(),
                                    (Twist() << -0.2, 0.1, 0, 0.05, -0.2, 0).finished()};

TEST(CarryDepthToRows, GivesEachRowWhatItSees) {
  const PixelStore truth = store_of(true, kMotion);
  PixelStore store = store_of(false, kMotion);
  const double before = mean_difference(store, truth);
  carry_depth_to_rows(store, kMotion);
  EXPECT_LT(mean_difference(store, truth), 0.4 * before);
  for (const StoredPixel& pixel : store.pixels()) ASSERT_TRUE(pixel.depth.is_measured());
}

TEST(CarryDepthToRows, LeavesItWhereACameraDoesNotMove) {
  PixelStore store = store_of(false, kMotion);
  const PixelStore before = store;
  carry_depth_to_rows(store, std::vector<Twist>(kFrames, Twist::Zero()));
  EXPECT_LT(mean_difference(store, before), 1e-6);
}

TEST(CarryDepthToRows, WorksWhereOnlyAShareOfThePixelsIsStored) {
  constexpr std::size_t kStored = kFrames * kWidth * kHeight * 2 / 5;
  const PixelStore truth = store_of(true, kMotion, kStored);
  PixelStore store = store_of(false, kMotion, kStored);
  ASSERT_LT(store.pixels().size(), static_cast<std::size_t>(kFrames * kWidth * kHeight / 2));
  const double before = mean_difference(store, truth);
  carry_depth_to_rows(store, kMotion);
  EXPECT_LT(mean_difference(store, truth), 0.6 * before);
}

TEST(CarryDepthToRows, KeepsWhatIsKnownOfADepthAndTakesNoneFromAnotherLabel) {
  PixelStore store = store_of(false, kMotion);
  for (std::size_t i = 0; i < store.pixels().size(); ++i) {
    const StoredPixel& pixel = store.pixels()[i];
    const float metres = pixel.depth.metres();
    const bool is_ball = metres < 2.2F;
    store.change_label(i, is_ball ? 2 : 0);
    store.change_depth(i, is_ball ? StoredDepth::guessed(metres) : StoredDepth::extended(metres));
  }
  carry_depth_to_rows(store, kMotion);
  for (const StoredPixel& pixel : store.pixels()) {
    ASSERT_TRUE(pixel.depth.is_guessed());
    ASSERT_EQ(pixel.depth.is_extended(), pixel.label == 0);
    ASSERT_EQ(pixel.depth.metres() < 2.2F, pixel.label == 2);
  }
}

TEST(CarryDepthToRows, LeavesUnknownDepthUnknown) {
  PixelStore store = store_of(false, kMotion);
  for (std::size_t i = 0; i < store.pixels().size(); ++i) store.change_depth(i, StoredDepth::unknown());
  carry_depth_to_rows(store, kMotion);
  for (const StoredPixel& pixel : store.pixels()) ASSERT_FALSE(pixel.depth.is_known());
}

TEST(CarryDepthToRows, GivesTheSameForAnyNumberOfThreads) {
  const auto carried_with = [](int threads) {
    set_thread_count(threads);
    PixelStore store = store_of(false, kMotion);
    carry_depth_to_rows(store, kMotion);
    set_thread_count(0);
    return store;
  };
  EXPECT_EQ(mean_difference(carried_with(1), carried_with(3)), 0);
}

} // namespace
} // namespace kinora::fields
