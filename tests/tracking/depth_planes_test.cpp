#include "tracking/depth_planes.h"

#include <limits>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/parallel.h"
#include "tracking/synthetic_scene.h"

namespace kinora::tracking {
namespace {

using testing::pose_at;
using testing::render_frame;
using testing::ShapeKind;

ingest::Frame plane_frame(double noise) {
  testing::SceneOptions options;
  options.noise = noise;
  return render_frame({ShapeKind::kPlane, {0, 0, 0}, false}, pose_at({0, 0, 1.5}, 25, -30), SE3::Identity(), 0,
                      options);
}

double mean_normal_error(const DepthPlanes& fitted, const Eigen::Vector3d& truth) {
  double sum = 0;
  double count = 0;
  for (int v = 0; v < fitted.weights.height(); ++v) {
    for (int u = 0; u < fitted.weights.width(); ++u) {
      if (fitted.weights.at(u, v) <= 0) continue;
      const float* plane = fitted.planes.pixel(u, v);
      const Eigen::Vector3d normal(plane[0], plane[1], plane[2]);
      sum += std::acos(std::min(1.0, normal.dot(truth)));
      count += 1;
    }
  }
  EXPECT_GT(count, 0);
  return sum / count;
}

TEST(DepthPlanes, AreExactOnASlantedPlane) {
  const ingest::Frame frame = plane_frame(0);
  const DepthPlanes fitted = fit_depth_planes(frame.depth, frame.camera.intrinsics);
  const Eigen::Vector3d normal = pose_at({0, 0, 0}, 25, -30) * Eigen::Vector3d(0, 0, -1);
  EXPECT_LT(mean_normal_error(fitted, normal), 2e-3);
  const float* plane = fitted.planes.pixel(100, 80);
  const Eigen::Vector3d point = frame.camera.intrinsics.unproject(100, 80, frame.depth.at(100, 80));
  EXPECT_NEAR(plane[0] * point.x() + plane[1] * point.y() + plane[2] * point.z() + plane[3], 0, 1e-5);
  EXPECT_GT(plane[3], 0) << "the camera is on the positive side";
}

TEST(DepthPlanes, AverageTheSensorsNoise) {
  const ingest::Frame frame = plane_frame(1);
  const DepthPlanes fitted = fit_depth_planes(frame.depth, frame.camera.intrinsics);
  const Eigen::Vector3d normal = pose_at({0, 0, 0}, 25, -30) * Eigen::Vector3d(0, 0, -1);
  EXPECT_LT(mean_normal_error(fitted, normal), 0.15);
}

TEST(DepthPlanes, DoNotMixTheObjectWithTheWallBehind) {
  const ingest::Frame frame = render_frame({}, pose_at({0, 0, 1.2}, 0, 0), SE3::Identity(), 0);
  const DepthPlanes fitted = fit_depth_planes(frame.depth, frame.camera.intrinsics);
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      if (fitted.weights.at(u, v) <= 0) continue;
      EXPECT_NEAR(fitted.planes.at(u, v, 3), frame.depth.at(u, v), 1e-3) << u << ' ' << v;
    }
  }
}

TEST(DepthPlanes, IgnoreMaskedAndAbsurdDepth) {
  ingest::Frame frame = plane_frame(0);
  LabelImage allowed(frame.depth.width(), frame.depth.height());
  for (int v = 0; v < allowed.height(); ++v) {
    for (int u = 100; u < 200; ++u) allowed.at(u, v) = 1;
  }
  for (int v = 0; v < allowed.height(); ++v) {
    frame.depth.at(120, v) = std::numeric_limits<float>::quiet_NaN();
    frame.depth.at(130, v) = -1;
    frame.depth.at(140, v) = std::numeric_limits<float>::infinity();
  }
  const DepthPlanes fitted = fit_depth_planes(frame.depth, frame.camera.intrinsics, allowed);
  EXPECT_EQ(fitted.weights.at(99, 50), 0);
  EXPECT_GT(fitted.weights.at(110, 50), 0);
  for (const int u : {120, 130, 140}) EXPECT_EQ(fitted.weights.at(u, 50), 0);
  for (const float value : fitted.planes.values()) EXPECT_TRUE(std::isfinite(value));
}

TEST(DepthPlanes, AreEmptyForAnEmptyPicture) {
  const DepthPlanes none = fit_depth_planes(DepthImage(), Intrinsics{0, 0, 1, 1, 0, 0});
  EXPECT_TRUE(none.planes.empty());
  const DepthPlanes zero = fit_depth_planes(DepthImage(7, 3), Intrinsics{7, 3, 10, 10, 3, 1});
  for (const float weight : zero.weights.values()) EXPECT_EQ(weight, 0);
}

TEST(DepthPlanes, RejectAMaskOfAnotherSize) {
  EXPECT_THROW(fit_depth_planes(DepthImage(8, 8), Intrinsics{8, 8, 10, 10, 4, 4}, LabelImage(8, 7)), Error);
}

TEST(DepthPlanes, HaveTheSameBitsForAnyNumberOfThreads) {
  const ingest::Frame frame = plane_frame(1);
  set_thread_count(1);
  const DepthPlanes one = fit_depth_planes(frame.depth, frame.camera.intrinsics);
  set_thread_count(2);
  const DepthPlanes two = fit_depth_planes(frame.depth, frame.camera.intrinsics);
  set_thread_count(0);
  EXPECT_TRUE(std::equal(one.planes.values().begin(), one.planes.values().end(), two.planes.values().begin()));
  EXPECT_TRUE(std::equal(one.weights.values().begin(), one.weights.values().end(), two.weights.values().begin()));
}

} // namespace
} // namespace kinora::tracking
