#include "player/window/moving_resolution.h"

#include <gtest/gtest.h>

namespace kinora::player::window {
namespace {

/// What pictures take after a while on a machine that needs so long for one as large as the window, and how large they
/// are.
struct Settled {
  double milliseconds, scale;
};
Settled settled(double full_milliseconds) {
  MovingResolution resolution;
  double milliseconds = 0;
  for (int i = 0; i < 30; ++i) {
    milliseconds = full_milliseconds * resolution.scale() * resolution.scale();
    resolution.took(milliseconds);
  }
  return {milliseconds, resolution.scale()};
}

TEST(MovingResolution, DropsUntilPicturesComeAsOftenAsFrames) {
  for (const double full : {60.0, 120.0, 500.0, 1500.0}) {
    const auto [milliseconds, scale] = settled(full);
    EXPECT_LT(milliseconds, 1000.0 / 30) << full;
    EXPECT_GT(milliseconds, 20) << "smaller than it need be: " << full;
    EXPECT_LT(scale, 1);
  }
}

TEST(MovingResolution, IsTheWindowsWhereThatIsFastEnough) { EXPECT_EQ(settled(10).scale, MovingResolution::kLargest); }

TEST(MovingResolution, HasALeastSizeBelowWhichFramesAreLeftOut) {
  EXPECT_EQ(settled(1e5).scale, MovingResolution::kSmallest);
}

TEST(MovingResolution, OnePictureThatTookLongDoesNotMakeTheNextTiny) {
  MovingResolution resolution;
  const double before = resolution.scale();
  resolution.took(16 * MovingResolution::kWantedMilliseconds);
  EXPECT_DOUBLE_EQ(resolution.scale(), before / 2);
}

} // namespace
} // namespace kinora::player::window
