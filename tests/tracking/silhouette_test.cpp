#include "tracking/silhouette.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/random.h"

namespace kinora::tracking {
namespace {

double nearest_of_all(const LabelImage& allowed, int u, int v) {
  double least = std::numeric_limits<double>::infinity();
  for (int y = 0; y < allowed.height(); ++y) {
    for (int x = 0; x < allowed.width(); ++x) {
      if (allowed.at(x, y) != 0) least = std::min(least, std::hypot(x - u, y - v));
    }
  }
  return least;
}

TEST(Silhouette, OffsetsLeadToTheNearestPixel) {
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    LabelImage allowed(5 + static_cast<int>(random.below(40)), 5 + static_cast<int>(random.below(40)));
    for (std::uint32_t n = 1 + random.below(12); n > 0; --n) {
      allowed.at(static_cast<int>(random.below(static_cast<std::uint32_t>(allowed.width()))),
                 static_cast<int>(random.below(static_cast<std::uint32_t>(allowed.height())))) = 1;
    }
    const Image<std::int16_t> offsets = offsets_to_silhouette(allowed);
    for (int v = 0; v < allowed.height(); ++v) {
      for (int u = 0; u < allowed.width(); ++u) {
        const int du = offsets.at(u, v, 0);
        const int dv = offsets.at(u, v, 1);
        ASSERT_TRUE(allowed.contains(u + du, v + dv));
        EXPECT_NE(allowed.at(u + du, v + dv), 0);
        EXPECT_LT(std::hypot(du, dv), nearest_of_all(allowed, u, v) + 1);
      }
    }
  }
}

TEST(Silhouette, WithoutAnyPixelEverythingIsFar) {
  const Image<std::int16_t> offsets = offsets_to_silhouette(LabelImage(7, 4));
  for (int v = 0; v < 4; ++v) {
    for (int u = 0; u < 7; ++u) EXPECT_GE(std::hypot(offsets.at(u, v, 0), offsets.at(u, v, 1)), 7);
  }
}

} // namespace
} // namespace kinora::tracking
