#include "ingest/depth_cleaning.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "ingest/sensor_noise.h"

namespace kinora::ingest {
namespace {

constexpr Intrinsics kCamera{64, 48, 60, 60, 31.5, 23.5};

/// A plane through (0, 0, z) whose normal is turned by `angle` about the vertical axis, with the sensor's noise.
DepthImage plane(double z, double angle, double sigmas = 0) {
  DepthImage depth(kCamera.width, kCamera.height);
  Random random(7);
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u) {
      const double x = (u - kCamera.cx) / kCamera.fx;
      const double measured = z * std::cos(angle) / (std::cos(angle) + x * std::sin(angle));
      if (measured > 0.2 && measured < 15)
        depth.at(u, v) = static_cast<float>(measured + sigmas * depth_sigma(measured) * random.normal());
    }
  }
  return depth;
}

int kept(const DepthImage& depth) {
  return static_cast<int>(std::count_if(depth.values().begin(), depth.values().end(), [](float z) { return z > 0; }));
}

TEST(DepthCleaning, KeepsAPlaneSeenFromTheFront) {
  const DepthImage depth = plane(2, 0);
  EXPECT_EQ(kept(clean_depth(depth, kCamera)), kCamera.width * kCamera.height);
}

TEST(DepthCleaning, KeepsNoisyPlanesAtEveryDistance) {
  for (const double z : {0.5, 1.0, 2.0, 4.0}) {
    const DepthImage depth = plane(z, 0.2, 1);
    EXPECT_GT(kept(clean_depth(depth, kCamera)), 0.97 * kCamera.width * kCamera.height) << z;
  }
}

TEST(DepthCleaning, NeverChangesWhatItKeeps) {
  const DepthImage depth = plane(2, 0.8, 1);
  const DepthImage clean = clean_depth(depth, kCamera);
  for (std::size_t i = 0; i < depth.pixel_count(); ++i)
    EXPECT_TRUE(clean.data()[i] == 0 || clean.data()[i] == depth.data()[i]);
}

TEST(DepthCleaning, DropsTwoPixelsOnBothSidesOfAnEdge) {
  DepthImage depth(kCamera.width, kCamera.height, 1, 2.0F);
  for (int v = 0; v < depth.height(); ++v)
    for (int u = 0; u < 30; ++u) depth.at(u, v) = 1.5F;
  const DepthImage clean = clean_depth(depth, kCamera);
  for (int u = 0; u < depth.width(); ++u) EXPECT_EQ(clean.at(u, 20) == 0, u >= 28 && u <= 31) << u;
}

TEST(DepthCleaning, DropsFlyingPixels) {
  DepthImage depth(kCamera.width, kCamera.height, 1, 2.0F);
  depth.at(20, 20) = 1.7F;
  const DepthImage clean = clean_depth(depth, kCamera);
  EXPECT_EQ(clean.at(20, 20), 0);
  EXPECT_GT(clean.at(24, 20), 0);
}

TEST(DepthCleaning, ErodesOnePixelAroundHolesButNotAtTheImagesEdge) {
  DepthImage depth(kCamera.width, kCamera.height, 1, 2.0F);
  depth.at(20, 20) = 0;
  const DepthImage clean = clean_depth(depth, kCamera);
  EXPECT_EQ(kept(clean), kCamera.width * kCamera.height - 5);
  EXPECT_EQ(clean.at(21, 20), 0);
  EXPECT_GT(clean.at(21, 21), 0);
  EXPECT_GT(clean.at(0, 0), 0);
}

TEST(DepthCleaning, DropsSurfacesSeenAtLessThanTenDegrees) {
  // The angle between the plane and the central ray is 90° − angle.
  const auto centre_kept = [](double degrees) {
    const DepthImage clean = clean_depth(plane(1, degrees * EIGEN_PI / 180), kCamera, {.max_jump = 0.5});
    return clean.at(32, 24) > 0;
  };
  EXPECT_TRUE(centre_kept(60));
  EXPECT_TRUE(centre_kept(77));
  EXPECT_FALSE(centre_kept(83));
}

TEST(DepthCleaning, SmallStepsWithinTheNoiseAreNoEdges) {
  const auto step_kept = [](float z, float step) {
    DepthImage depth(kCamera.width, kCamera.height, 1, z);
    for (int v = 0; v < depth.height(); ++v)
      for (int u = 30; u < depth.width(); ++u) depth.at(u, v) = z + step;
    return clean_depth(depth, kCamera).at(30, 20) > 0;
  };
  EXPECT_TRUE(step_kept(2, 0.05F));
  EXPECT_FALSE(step_kept(2, 0.07F));
  EXPECT_TRUE(step_kept(8, 0.40F)); // σ(8 m) = 11 cm
  EXPECT_FALSE(step_kept(8, 0.60F));
}

TEST(DepthCleaning, ImagesOfOneRowOrColumnOrOnlyHolesAreFine) {
  EXPECT_EQ(kept(clean_depth(DepthImage(5, 1, 1, 1.0F), {5, 1, 5, 5, 2, 0})), 5);
  EXPECT_EQ(kept(clean_depth(DepthImage(1, 5, 1, 1.0F), {1, 5, 5, 5, 0, 2})), 5);
  EXPECT_EQ(kept(clean_depth(DepthImage(5, 5), {5, 5, 5, 5, 2, 2})), 0);
}

} // namespace
} // namespace kinora::ingest
