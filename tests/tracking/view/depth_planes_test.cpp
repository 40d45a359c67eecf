#include "tracking/view/depth_planes.h"

#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "core/sensor_noise.h"
#include "support/every_instruction_set.h"
#include "tracking/scenes/synthetic_scene.h"

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

/// The plane of one pixel, term by term.
struct PlainPlane {
  std::array<double, 4> plane{};
  double weight = 0;
};

PlainPlane fit_plainly(const DepthImage& depth, const Intrinsics& camera, const LabelImage& allowed, int u, int v) {
  const auto usable = [&](int x, int y) {
    return depth.contains(x, y) && depth.at(x, y) > 0 && depth.at(x, y) < 1e3F && allowed.at(x, y) != 0;
  };
  PlainPlane result;
  if (!usable(u, v)) return result;
  const double z = depth.at(u, v);
  const double gate = 4 * kSensorNoise.sigma(z) + 6 / camera.fx * z;
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  Eigen::Vector3d values = Eigen::Vector3d::Zero();
  for (int dv = -2; dv <= 2; ++dv) {
    for (int du = -2; du <= 2; ++du) {
      if (!usable(u + du, v + dv) || std::abs(depth.at(u + du, v + dv) - z) >= gate) continue;
      const Eigen::Vector3d row(1, du, dv);
      products += row * row.transpose();
      values += row / depth.at(u + du, v + dv);
    }
  }
  const double n = products(0, 0);
  const Eigen::Vector2d mean = products.block<2, 1>(1, 0) / n;
  const Eigen::Matrix2d spread = products.block<2, 2>(1, 1) - n * mean * mean.transpose();
  if (n < 6 || spread.determinant() < 0.05 * spread.trace() * spread.trace()) return result;
  const Eigen::Vector3d fit = products.ldlt().solve(values);
  if (!(fit[0] > 0)) return result;
  const Eigen::Vector3d ray = camera.unproject(u, v, 1);
  const double a = fit[1] * camera.fx;
  const double b = fit[2] * camera.fy;
  const Eigen::Vector3d inverse(a, b, fit[0] - a * ray.x() - b * ray.y());
  const Eigen::Vector3d normal = -inverse.normalized();
  result.plane = {normal.x(), normal.y(), normal.z(), 1 / inverse.norm()};
  const double ratio = kSensorNoise.sigma(1) / kSensorNoise.sigma(1 / fit[0]);
  result.weight = fit[0] / inverse.norm() / ray.norm() * ratio * ratio;
  return result;
}

class DepthPlanesOnEveryInstructionSet : public OnEveryInstructionSet {};

TEST_P(DepthPlanesOnEveryInstructionSet, AreThoseOfAPlainFit) {
  Random random(9);
  const Intrinsics camera{67, 41, 80, 82, 31, 19};
  DepthImage depth(camera.width, camera.height);
  LabelImage allowed(camera.width, camera.height);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      allowed.at(u, v) = random.below(9) > 0 && u > 3 + v / 8 ? 1 : 0;
      const float wall = u > 30 ? 1.1F : 1.4F + 0.004F * static_cast<float>(u);
      depth.at(u, v) = random.below(9) == 0 ? 0.0F : wall + 0.002F * static_cast<float>(random.normal());
    }
  }
  depth.at(40, 20) = std::numeric_limits<float>::quiet_NaN();
  depth.at(41, 20) = std::numeric_limits<float>::infinity();
  const DepthPlanes fitted = fit_depth_planes(depth, camera, allowed);
  int planes = 0;
  int different = 0; // where rounding decides whether there is one
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const PlainPlane expected = fit_plainly(depth, camera, allowed, u, v);
      ASSERT_TRUE(std::isfinite(fitted.weights.at(u, v)));
      if ((expected.weight > 0) != (fitted.weights.at(u, v) > 0)) {
        ++different;
        continue;
      }
      planes += expected.weight > 0 ? 1 : 0;
      EXPECT_NEAR(fitted.weights.at(u, v), expected.weight, 1e-3) << u << ' ' << v;
      for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(fitted.planes.pixel(u, v)[i], expected.plane[i], 1e-3) << u << ' ' << v;
      }
    }
  }
  EXPECT_GT(planes, 1000);
  EXPECT_LE(different, 2);
}

INSTANTIATE_TEST_SUITE_P(Sets, DepthPlanesOnEveryInstructionSet, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::tracking
