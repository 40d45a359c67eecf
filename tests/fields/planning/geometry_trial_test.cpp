#include <gtest/gtest.h>

#include "fields/planning/geometry_trial.h"
#include "fields/scenes/analytic_scene.h"

namespace kinora::fields {
namespace {

TEST(GeometryTrial, PrefersTrueColorAndThenTrueDepth) {
  EXPECT_EQ(better_geometry({10, 0.01}, {9, 0.02}), Geometry::kSignedDistance);
  EXPECT_EQ(better_geometry({9, 0.02}, {10, 0.01}), Geometry::kDensity);
  EXPECT_EQ(better_geometry({10, 0.01}, {10.02, 0.009}), Geometry::kSignedDistance);
  EXPECT_EQ(better_geometry({10.02, 0.009}, {10, 0.01}), Geometry::kDensity);
}

TEST(GeometryTrial, MeasuresBothGeometriesInFramesThatAreLeftOut) {
  const PixelStore store = store_of(Scene{});
  const auto still = motion::Motion::still();
  Progress progress;
  const GeometryTrial trial =
      try_geometries({store, 2, still}, choose_field_config({store, 2, still}), short_training(), progress);
  EXPECT_EQ(trial.frames, 3U);
  EXPECT_EQ(trial.chosen, better_geometry(trial.density, trial.signed_distance));
  EXPECT_NE(trial.density.color, trial.signed_distance.color);
  for (const DrawingError& error : {trial.density, trial.signed_distance}) {
    EXPECT_GT(error.color, 0.1); // no picture is perfect
    EXPECT_LT(error.color, 40);
    EXPECT_LT(error.depth, 0.03);
  }
}

TEST(GeometryTrial, KeepsDensityWhereTooFewFramesCanBeLeftOut) {
  PixelStore store(100'000, 2);
  for (int i = 0; i < 2; ++i) store.add(Scene{}.frame(i, 0.05 * i), i);
  const auto still = motion::Motion::still();
  Progress progress;
  const GeometryTrial trial =
      try_geometries({store, 2, still}, choose_field_config({store, 2, still}), short_training(), progress);
  EXPECT_EQ(trial.chosen, Geometry::kDensity);
  EXPECT_EQ(trial.frames, 0U);
  EXPECT_EQ(trial.rays, 0U);
}

TEST(PixelStore, LeavesOutFramesAndKeepsAShareOfTheOthers) {
  const PixelStore store = store_of(Scene{});
  const PixelStore part = store.thinned({0, 5}, 10'000);
  ASSERT_EQ(part.frames().size(), 10U);
  EXPECT_EQ(part.frames()[0].frame, 1);
  EXPECT_EQ(part.frames()[4].frame, 6);
  EXPECT_NEAR(static_cast<double>(part.pixels().size()), 10'000.0 * 10 / 12, 400);
  EXPECT_EQ(part.frames().back().end, part.pixels().size());
  EXPECT_EQ(store.thinned({}, 1'000'000).pixels().size(), store.pixels().size());
}

} // namespace
} // namespace kinora::fields
