// How far drawn normals are from those of a known surface.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fields/rendering/renderer.h"

namespace kinora::fields::testing {

struct NormalError {
  double mean = 0;  ///< degrees, over pixels that see the surface at less than `steepest`
  double worst = 0; ///< the same
};

/// `normal_of(point)`: unit normal of the true surface at a world point near it.
template <class Normal>
inline NormalError normal_error(const Picture& picture, const Camera& camera, const Normal& normal_of) {
  constexpr double kSteepest = 75; // degrees: beyond, a pixel sees several cells
  NormalError error;
  int count = 0;
  for (int v = 0; v < picture.depth.height(); ++v) {
    for (int u = 0; u < picture.depth.width(); ++u) {
      const Eigen::Vector3d drawn = Eigen::Map<const Eigen::Vector3f>(picture.normal.pixel(u, v)).cast<double>();
      if (picture.depth.at(u, v) <= 0) {
        EXPECT_EQ(drawn.norm(), 0);
        continue;
      }
      EXPECT_NEAR(drawn.norm(), 1, 1e-5);
      const Eigen::Vector3d ray = camera.intrinsics.unproject(u, v, 1);
      const Eigen::Vector3d point = camera.camera_to_world * Eigen::Vector3d(picture.depth.at(u, v) * ray);
      const Eigen::Vector3d truth = camera.camera_to_world.linear().transpose() * normal_of(point);
      const double degrees = 180 / std::numbers::pi;
      if (std::acos(std::clamp(-truth.dot(ray.normalized()), -1.0, 1.0)) * degrees > kSteepest) continue;
      const double angle = std::acos(std::clamp(truth.dot(drawn), -1.0, 1.0)) * degrees;
      error.mean += angle;
      error.worst = std::max(error.worst, angle);
      ++count;
    }
  }
  EXPECT_GT(count, 200);
  error.mean /= count;
  return error;
}

} // namespace kinora::fields::testing
