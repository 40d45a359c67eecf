#include "ingest/depth/registration.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"

namespace kinora::ingest {
namespace {

/// A depth camera 5 cm to the left of a colour camera that is turned a little and has more pixels.
RegistrationGeometry two_cameras() {
  RegistrationGeometry geometry;
  geometry.depth = {160, 120, 100, 100, 79.5, 59.5};
  geometry.color = {240, 180, 170, 172, 119, 90};
  geometry.depth_to_color = exp_se3((Twist() << -0.05, 0.01, 0.004, 0.01, 0.02, -0.015).finished());
  return geometry;
}

/// Depth of a plane n·p = d of the depth camera as another camera sees it, exactly.
DepthImage plane_seen_by(const Intrinsics& camera, const SE3& depth_to_camera, const Eigen::Vector3d& normal,
                         double distance) {
  const Eigen::Vector3d rotated_normal = depth_to_camera.linear() * normal;
  const double offset = distance + rotated_normal.dot(depth_to_camera.translation());
  DepthImage depth(camera.width, camera.height);
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u)
      depth.at(u, v) = static_cast<float>(offset / rotated_normal.dot(camera.unproject(u, v, 1)));
  return depth;
}

TEST(Registration, OfAPlaneIsThePlaneThatTheColourCameraSees) {
  const RegistrationGeometry geometry = two_cameras();
  const Eigen::Vector3d normal = Eigen::Vector3d(0.2, -0.15, 1).normalized();
  const DepthImage depth = plane_seen_by(geometry.depth, SE3::Identity(), normal, 1.5);
  const DepthImage truth = plane_seen_by(geometry.color, geometry.depth_to_color, normal, 1.5);
  const DepthImage registered = register_depth(depth, geometry);
  ASSERT_TRUE(registered.same_size(truth));
  int measured = 0;
  for (std::size_t i = 0; i < truth.pixel_count(); ++i) {
    if (registered.data()[i] <= 0) continue;
    ++measured;
    EXPECT_NEAR(registered.data()[i], truth.data()[i], 5e-4);
  }
  // The depth camera sees more than the colour camera, so that only a rim can be missing.
  EXPECT_GT(measured, 0.93 * static_cast<double>(truth.pixel_count()));
  for (int v = 20; v < 160; ++v)
    for (int u = 30; u < 220; ++u) EXPECT_GT(registered.at(u, v), 0) << u << " " << v;
}

TEST(Registration, NearSurfaceHidesWhatIsBehindItAndLeavesAHoleWhereNothingWasSeen) {
  RegistrationGeometry geometry = two_cameras();
  geometry.depth_to_color = SE3(Eigen::Translation3d(-0.1, 0, 0));
  DepthImage depth(160, 120, 1, 2.0F);
  for (int v = 40; v < 80; ++v)
    for (int u = 60; u < 100; ++u) depth.at(u, v) = 1.0F;
  const DepthImage registered = register_depth(depth, geometry);
  // The colour camera is 10 cm to the right: the near square moves left by f·0.1/1, the wall by half as much.
  const auto column = [&](int u, double z) {
    const Eigen::Vector3d point = geometry.depth_to_color * geometry.depth.unproject(u, 60, z);
    return static_cast<int>(std::lround(geometry.color.project(point).x()));
  };
  const int left = column(60, 1), right = column(99, 1), wall_right = column(100, 2);
  ASSERT_GT(wall_right, right + 4);
  for (int u = left + 1; u < right; ++u) EXPECT_NEAR(registered.at(u, 90), 1.0, 1e-5) << u;
  for (int u = right + 2; u < wall_right - 1; ++u) EXPECT_EQ(registered.at(u, 90), 0) << u;
  for (int u = wall_right + 1; u < wall_right + 20; ++u) EXPECT_NEAR(registered.at(u, 90), 2.0, 1e-5) << u;
}

TEST(Registration, HolesStayHolesAndLonelyMeasurementsStay) {
  RegistrationGeometry geometry = two_cameras();
  geometry.color = geometry.depth;
  geometry.depth_to_color = SE3::Identity();
  DepthImage depth(160, 120, 1, 1.25F);
  for (int v = 50; v < 60; ++v)
    for (int u = 70; u < 90; ++u) depth.at(u, v) = 0;
  depth.at(80, 55) = 0.7F;
  EXPECT_EQ(register_depth(depth, geometry).at(80, 55), 0.7F);
  const DepthImage registered = register_depth(depth, geometry);
  for (std::size_t i = 0; i < depth.pixel_count(); ++i) EXPECT_EQ(registered.data()[i], depth.data()[i]);
}

TEST(Registration, HasTheSameBitsForAnyNumberOfThreads) {
  const RegistrationGeometry geometry = two_cameras();
  DepthImage depth(160, 120);
  Random random(5);
  for (float& z : depth.values()) z = random.uniform() < 0.2F ? 0.0F : 0.5F + 2 * random.uniform();
  set_thread_count(1);
  const DepthImage one = register_depth(depth, geometry);
  set_thread_count(3);
  const DepthImage three = register_depth(depth, geometry);
  set_thread_count(0);
  EXPECT_TRUE(std::equal(one.values().begin(), one.values().end(), three.values().begin()));
}

TEST(Registration, RefusesAnImageOfAnotherSize) {
  EXPECT_THROW(register_depth(DepthImage(8, 8, 1, 1.0F), two_cameras()), Error);
}

TEST(Registration, SurvivesMeasurementsBehindOrBesideTheColourCamera) {
  RegistrationGeometry geometry = two_cameras();
  geometry.depth_to_color = SE3(Eigen::Translation3d(0, 0, -1)); // at 1 m everything lies in the camera's own plane
  DepthImage depth(160, 120, 1, 1.0F);
  for (int u = 0; u < 160; ++u) depth.at(u, 3) = std::nextafter(1.0F, 2.0F);
  depth.at(5, 5) = std::numeric_limits<float>::quiet_NaN();
  const DepthImage registered = register_depth(depth, geometry);
  for (const float z : registered.values()) EXPECT_TRUE(std::isfinite(z) && z >= 0);
}

} // namespace
} // namespace kinora::ingest
