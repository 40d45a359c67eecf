// Pictures smaller than what a field resolves.
#include <gtest/gtest.h>

#include <cmath>

#include "fields/rendering/renderer.h"
#include "fields/scenes/drawn_scene.h"

namespace kinora::fields {
namespace {

using testing::camera_at;
using testing::kBox;
using testing::kCell;
using testing::painted_field;

/// A slab before the camera, chequered in squares of two cells.
Field chequered_slab() {
  return painted_field(kBox, [](const Eigen::Vector3d& p) {
    const auto square = [](double x) { return static_cast<int>(std::floor(x / (2 * kCell) + 1e-6)); };
    const bool white = ((square(p.x()) + square(p.y())) & 1) != 0;
    return testing::Paint{std::abs(p.z()) - 3 * kCell, white ? Eigen::Vector3d(1, 1, 1) : Eigen::Vector3d(0, 0, 0)};
  });
}

/// A pixel of the small picture covers 4 × 4 cells of the slab.
constexpr int kSmall = 48;
constexpr int kTimes = 4;
Camera camera_before_slab(double shift, int times = 1) {
  const double distance = 4 * kCell * kSmall / 2 + 3 * kCell;
  return camera_at({shift, 0, -distance}, {shift, 0, 0}, kSmall * times, kSmall * times);
}

Picture draw(const DrawableField& field, const Camera& camera, int samples = kTimes) {
  const PosedField posed{&field};
  return render({&posed, 1}, camera, {.samples = samples});
}

/// Calls `visit` with each pixel of the small picture that sees the slab alone.
template <class Visit> void for_inner_pixels(const Visit& visit) {
  for (int v = kSmall / 2 - 6; v < kSmall / 2 + 6; ++v) {
    for (int u = kSmall / 2 - 6; u < kSmall / 2 + 6; ++u) visit(u, v);
  }
}

TEST(Antialiasing, ASmallPictureIsALargeOneAveraged) {
  const DrawableField field(chequered_slab());
  const Picture small = draw(field, camera_before_slab(0.003));
  const Picture large = draw(field, camera_before_slab(0.003, kTimes), 1);
  double error = 0, contrast = 0;
  for_inner_pixels([&](int u, int v) {
    double mean = 0, power = 0;
    for (int i = 0; i < kTimes * kTimes; ++i) {
      const double value = large.color.at(kTimes * u + i % kTimes, kTimes * v + i / kTimes, 0);
      mean += value / (kTimes * kTimes);
      power += value * value / (kTimes * kTimes);
    }
    error += std::abs(small.color.at(u, v, 0) - mean) / 144;
    contrast += std::sqrt(power - mean * mean) / 144;
    EXPECT_EQ(small.color.at(u, v, 3), 255);
    EXPECT_NEAR(small.depth.at(u, v), large.depth.at(kTimes * u, kTimes * v), kCell);
  });
  EXPECT_GT(contrast, 40) << "the squares must show in the large picture";
  EXPECT_LT(error, 5);
}

TEST(Antialiasing, NothingFlickersWhenTheCameraMovesByLessThanAPixel) {
  const DrawableField field(chequered_slab());
  const Picture here = draw(field, camera_before_slab(0));
  for (const double cells : {0.5, 1.0, 1.7, 2.0}) {
    const Picture there = draw(field, camera_before_slab(cells * kCell));
    double difference = 0;
    for_inner_pixels([&](int u, int v) {
      difference += std::abs(static_cast<double>(here.color.at(u, v, 0)) - there.color.at(u, v, 0)) / 144;
    });
    EXPECT_LT(difference, 12) << "moved by " << cells << " cells";
  }
}

// Half a pixel of one depth and half of another is one of the two, never what lies between them.
TEST(Antialiasing, DepthIsNotAveragedAcrossEdges) {
  const DrawableField field(painted_field(kBox, [](const Eigen::Vector3d& p) {
    return testing::Paint{std::abs(p.z() - (p.x() < 0.01 ? 0 : 0.3)) - 3 * kCell, {1, 1, 1}};
  }));
  const double distance = 4 * kCell * kSmall / 2 + 3 * kCell;
  const Picture picture = draw(field, camera_before_slab(0));
  for_inner_pixels([&](int u, int v) {
    const double depth = picture.depth.at(u, v) - (distance - 3 * kCell);
    EXPECT_LT(std::min(std::abs(depth), std::abs(depth - 0.3)), 2 * kCell) << u << ' ' << v;
  });
}

} // namespace
} // namespace kinora::fields
