#include "tracking/view/texture.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace kinora::tracking {
namespace {

constexpr int kSide = 64;
constexpr double kRadius = 20;

// A ball in the middle: 2 inside, 1 within two pixels of its rim.
LabelImage ball_mask() {
  LabelImage mask(kSide, kSide);
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      const double across = std::hypot(u - kSide / 2, v - kSide / 2);
      mask.at(u, v) = across < kRadius - 3 ? 2 : across < kRadius ? 1 : 0;
    }
  }
  return mask;
}

// Lit from the camera and all about, with a print of squares of five pixels.
Image<float> lit_ball(double print) {
  Image<float> texture(kSide, kSide);
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      const double across = std::min(0.99, std::hypot(u - kSide / 2, v - kSide / 2) / kRadius);
      const double square = (u / 5 + v / 5) % 2 == 0 ? 0.5 : -0.5;
      texture.at(u, v) = static_cast<float>(std::log(0.4 + 0.6 * std::sqrt(1 - across * across)) + print * square);
    }
  }
  return texture;
}

double detailed_share(double print) {
  const LabelImage mask = ball_mask();
  const LabelImage detail = detail_of(lit_ball(print), mask);
  double inner = 0;
  double detailed = 0;
  for (std::size_t i = 0; i < mask.values().size(); ++i) {
    if (mask.values()[i] != 2) {
      EXPECT_EQ(detail.values()[i], 0);
      continue;
    }
    inner += 1;
    detailed += detail.values()[i];
  }
  return detailed / inner;
}

TEST(DetailOf, TellsPrintFromLight) {
  EXPECT_LT(detailed_share(0), 0.2);
  EXPECT_GT(detailed_share(0.2), 0.9);
}

TEST(DetailOf, IsNoneInAPictureSmallerThanItsWindow) {
  const LabelImage detail = detail_of(Image<float>(3, 2), LabelImage(3, 2));
  EXPECT_EQ(std::count(detail.values().begin(), detail.values().end(), 0), 6);
}

} // namespace
} // namespace kinora::tracking
