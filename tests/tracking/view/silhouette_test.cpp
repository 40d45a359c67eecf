#include "tracking/view/silhouette.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/random.h"
#include "support/every_instruction_set.h"

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

// One pixel after the other.
Image<std::int16_t> plain_sweeps(const LabelImage& allowed) {
  const int width = allowed.width();
  const int height = allowed.height();
  const auto far = static_cast<std::int16_t>(2 * (width + height));
  Image<std::int16_t> offsets(width, height, 2);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      if (allowed.at(u, v) == 0) offsets.at(u, v, 0) = offsets.at(u, v, 1) = far;
    }
  }
  const auto propagate = [&](int u, int v, int du, int dv) {
    if (!offsets.contains(u, v) || !offsets.contains(u + du, v + dv)) return;
    const int x = offsets.at(u + du, v + dv, 0) + du;
    const int y = offsets.at(u + du, v + dv, 1) + dv;
    std::int16_t* offset = offsets.pixel(u, v);
    if (x * x + y * y >= offset[0] * offset[0] + offset[1] * offset[1]) return;
    offset[0] = static_cast<std::int16_t>(x);
    offset[1] = static_cast<std::int16_t>(y);
  };
  for (const int dv : {-1, 1}) {
    for (int i = 0; i < height; ++i) {
      const int v = dv < 0 ? i : height - 1 - i;
      for (int u = 0; u < width; ++u) {
        for (int du = -1; du <= 1; ++du) propagate(u, v, du, dv);
      }
      for (int u = 1; u < width; ++u) propagate(u, v, -1, 0);
      for (int u = width - 1; u-- > 0;) propagate(u, v, 1, 0);
    }
  }
  return offsets;
}

class SilhouetteOnEveryInstructionSet : public OnEveryInstructionSet {};

LabelImage random_blots(Random& random) {
  LabelImage allowed(1 + static_cast<int>(random.below(90)), 1 + static_cast<int>(random.below(60)));
  for (std::uint32_t n = random.below(6); n > 0; --n) {
    const int u0 = static_cast<int>(random.below(static_cast<std::uint32_t>(allowed.width())));
    const int v0 = static_cast<int>(random.below(static_cast<std::uint32_t>(allowed.height())));
    const double radius = 12 * random.uniform_double();
    for (int v = 0; v < allowed.height(); ++v) {
      for (int u = 0; u < allowed.width(); ++u) {
        if (std::hypot(u - u0, v - v0) <= radius) allowed.at(u, v) = 1;
      }
    }
  }
  return allowed;
}

TEST_P(SilhouetteOnEveryInstructionSet, OffsetsAreThoseOfPlainSweeps) {
  Random random(4);
  for (int trial = 0; trial < 60; ++trial) {
    const LabelImage allowed = random_blots(random);
    const Image<std::int16_t> found = offsets_to_silhouette(allowed);
    const Image<std::int16_t> expected = plain_sweeps(allowed);
    ASSERT_TRUE(std::equal(found.values().begin(), found.values().end(), expected.values().begin())) << trial;
  }
}

TEST_P(SilhouetteOnEveryInstructionSet, OffsetsLeadToTheNearestPixel) {
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

INSTANTIATE_TEST_SUITE_P(Sets, SilhouetteOnEveryInstructionSet, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::tracking
