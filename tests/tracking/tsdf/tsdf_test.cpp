#include "tracking/tsdf/tsdf.h"

#include <limits>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/parallel.h"
#include "tracking/scenes/synthetic_scene.h"

namespace kinora::tracking {
namespace {

using testing::distance_to;
using testing::pose_at;
using testing::render_frame;
using testing::Shape;
using testing::ShapeKind;

const Shape kBox{ShapeKind::kBox, {0.12, 0.09, 0.07}, true};
const Shape kSphere{ShapeKind::kSphere, {0.1, 0, 0}, true};
const TsdfConfig kConfig{0.005, 0.025, 64};

LabelImage object_mask(const ingest::Frame& frame) {
  LabelImage mask = frame.labels;
  for (std::uint8_t& value : mask.values()) value = value == 2 ? 1 : 0;
  return mask;
}

void integrate(TsdfVolume& volume, const ingest::Frame& frame, const SE3& camera_to_volume) {
  const DepthPlanes planes = fit_depth_planes(frame.depth, frame.camera.intrinsics, object_mask(frame));
  volume.integrate(planes, Image<float>(), frame.camera.intrinsics, camera_to_volume);
}

// Eight views around a shape at `centre`, fused into a volume whose space is the world.
TsdfVolume scanned(const Shape& shape, const Eigen::Vector3d& centre, double noise = 0) {
  TsdfVolume volume(kConfig, centre);
  testing::SceneOptions options;
  options.noise = noise;
  for (int i = 0; i < 8; ++i) {
    const SE3 around = pose_at(centre, 20, 45 * i) * Eigen::Translation3d(0, 0, -1);
    integrate(volume, render_frame(shape, SE3(Eigen::Translation3d(centre)), around, i, options), around);
  }
  return volume;
}

double mean_surface_error(const Shape& shape, const TsdfVolume& volume) {
  const std::vector<SurfacePoint> points = volume.surface_points();
  EXPECT_GT(points.size(), 500U);
  double sum = 0;
  for (const SurfacePoint& point : points) sum += std::abs(distance_to(shape, point.position.cast<double>()));
  return sum / static_cast<double>(points.size());
}

TEST(TsdfVolume, FindsTheSurfaceOfASphereWithinAMillimetre) {
  EXPECT_LT(mean_surface_error(kSphere, scanned(kSphere, {0, 0, 0})), 0.0005);
}

TEST(TsdfVolume, FindsTheSurfaceOfABoxWithinAMillimetre) {
  EXPECT_LT(mean_surface_error(kBox, scanned(kBox, {0, 0, 0})), 0.0005);
}

TEST(TsdfVolume, AveragesTheSensorsNoise) {
  EXPECT_LT(mean_surface_error(kSphere, scanned(kSphere, {0, 0, 0}, 1)), 0.001);
}

TEST(TsdfVolume, IsAsExactAKilometreFromTheOriginAsAtIt) {
  const TsdfVolume here = scanned(kSphere, {0, 0, 0}, 1);
  const Eigen::Vector3d far(1000, -600, 400);
  const TsdfVolume there = scanned(kSphere, far, 1);
  EXPECT_NEAR(mean_surface_error(kSphere, here), mean_surface_error(kSphere, there), 1e-4);
  for (const double z : {-0.11, -0.1, -0.09}) {
    const auto a = here.distance({0.01, 0.02, z});
    const auto b = there.distance(far + Eigen::Vector3d(0.01, 0.02, z));
    ASSERT_TRUE(a && b);
    EXPECT_NEAR(*a, *b, 1e-4);
  }
}

TEST(TsdfVolume, GivesDistanceAndNormalNearTheSurface) {
  const TsdfVolume volume = scanned(kSphere, {0, 0, 0});
  for (const double offset : {-0.01, -0.004, 0.0, 0.004, 0.01}) {
    const Eigen::Vector3d direction = Eigen::Vector3d(0.3, -0.5, -0.8).normalized();
    const auto sample = volume.sample((0.1 + offset) * direction);
    ASSERT_TRUE(sample) << offset;
    EXPECT_NEAR(sample->distance, offset, 0.0015);
    EXPECT_GT(sample->normal.dot(direction), 0.99);
    EXPECT_NEAR(sample->distance, *volume.distance((0.1 + offset) * direction), 1e-12);
  }
}

TEST(TsdfVolume, KnowsNothingOfWhatItHasNotSeen) {
  const TsdfVolume volume = scanned(kSphere, {0, 0, 0});
  EXPECT_FALSE(volume.distance({0, 0, 0}));
  EXPECT_FALSE(volume.distance({5, 5, 5}));
  EXPECT_FALSE(volume.sample({1e300, 0, 0}));
  EXPECT_FALSE(volume.intensity({0, 0, std::numeric_limits<double>::quiet_NaN()}));
  EXPECT_TRUE(TsdfVolume(kConfig, {0, 0, 0}).surface_points().empty());
}

TEST(TsdfVolume, KeepsTheIntensityOfTheSurface) {
  TsdfVolume volume(kConfig, {0, 0, 1});
  const ingest::Frame frame =
      render_frame({ShapeKind::kPlane, {0, 0, 0}, false}, pose_at({0, 0, 1}, 0, 0), SE3::Identity(), 0);
  Image<float> ramp(frame.depth.width(), frame.depth.height());
  for (int v = 0; v < ramp.height(); ++v) {
    for (int u = 0; u < ramp.width(); ++u) ramp.at(u, v) = static_cast<float>(0.5 * u + 0.25 * v);
  }
  const Intrinsics& camera = frame.camera.intrinsics;
  volume.integrate(fit_depth_planes(frame.depth, camera), ramp, camera, SE3::Identity());
  const auto value = volume.intensity(camera.unproject(100.3, 57.8, 1.0));
  ASSERT_TRUE(value);
  EXPECT_NEAR(*value, 0.5 * 100.3 + 0.25 * 57.8, 0.05);
}

TEST(TsdfVolume, CarvesWhatIsNoLongerThere) {
  TsdfVolume volume(kConfig, {0, 0, 1});
  const Shape plane{ShapeKind::kPlane, {0, 0, 0}, false};
  integrate(volume, render_frame(plane, pose_at({0, 0, 1}, 0, 0), SE3::Identity(), 0), SE3::Identity());
  ASSERT_NEAR(*volume.distance({0, 0, 1}), 0, 1e-3);
  for (int i = 1; i < 8; ++i) {
    integrate(volume, render_frame(plane, pose_at({0, 0, 1.5}, 0, 0), SE3::Identity(), i), SE3::Identity());
  }
  EXPECT_GT(*volume.distance({0, 0, 1}), 0.015);
}

// A mean over all that was ever seen would follow by a sixth of the way.
TEST(TsdfVolume, ForgetsWhatItSawLongAgo) {
  TsdfVolume volume({kConfig.voxel_size, kConfig.truncation, 8}, {0, 0, 1});
  const Shape plane{ShapeKind::kPlane, {0, 0, 0}, false};
  const ingest::Frame before = render_frame(plane, pose_at({0, 0, 1}, 0, 0), SE3::Identity(), 0);
  const ingest::Frame now = render_frame(plane, pose_at({0, 0, 1.01}, 0, 0), SE3::Identity(), 1);
  for (int i = 0; i < 100; ++i) integrate(volume, before, SE3::Identity());
  for (int i = 0; i < 20; ++i) integrate(volume, now, SE3::Identity());
  EXPECT_GT(*volume.distance({0, 0, 1}), 0.005);
}

TEST(TsdfVolume, IsNotCarvedByPixelsThatMayNotTeach) {
  TsdfVolume volume(kConfig, {0, 0, 1});
  integrate(volume, render_frame(kBox, pose_at({0, 0, 1}, 0, 0), SE3::Identity(), 0), SE3::Identity());
  const double before = *volume.distance({0, 0, 0.93});
  for (int i = 1; i < 6; ++i) {
    // The box has gone; the wall behind it is not the object's.
    integrate(volume, render_frame(kBox, pose_at({3, 0, 1}, 0, 0), SE3::Identity(), i), SE3::Identity());
  }
  EXPECT_EQ(*volume.distance({0, 0, 0.93}), before);
}

TEST(TsdfVolume, DoesNotChangeWhenAFrameIsRepeated) {
  TsdfVolume volume(kConfig, {0, 0, 1});
  const ingest::Frame frame = render_frame(kSphere, pose_at({0, 0, 1}, 0, 0), SE3::Identity(), 0);
  integrate(volume, frame, SE3::Identity());
  const double once = *volume.distance({0.02, 0.01, 0.9});
  for (int i = 0; i < 5; ++i) integrate(volume, frame, SE3::Identity());
  EXPECT_NEAR(*volume.distance({0.02, 0.01, 0.9}), once, 1e-6);
}

TEST(TsdfVolume, HasTheSameBitsForAnyNumberOfThreads) {
  set_thread_count(1);
  const std::vector<SurfacePoint> one = scanned(kBox, {0, 0, 0}, 1).surface_points();
  set_thread_count(2);
  const std::vector<SurfacePoint> two = scanned(kBox, {0, 0, 0}, 1).surface_points();
  set_thread_count(0);
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].position, two[i].position);
    ASSERT_EQ(one[i].normal, two[i].normal);
    ASSERT_EQ(one[i].weight, two[i].weight);
  }
}

// What a volume has, turned about the y axis; what had x < 0 is left behind.
TsdfVolume half_of(const TsdfVolume& volume, const SE3& rotation) {
  std::vector<SurfacePoint> surface = volume.surface_points();
  for (SurfacePoint& point : surface) point.position = (rotation * point.position.cast<double>()).cast<float>();
  TsdfVolume half(volume.config(), volume.origin());
  half.make_bricks(surface);
  const SE3 inverse = rotation.inverse();
  half.resample(volume, [&](std::size_t, const motion::PointLanes& points, motion::PointLanes& positions) {
    for (std::size_t i = 0; i < motion::PointLanes::kPoints; ++i) {
      const Eigen::Vector3f position = (inverse * points.at(i).cast<double>()).cast<float>();
      positions.set(i,
                    position.x() < 0 ? Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()) : position);
    }
  });
  return half;
}

TEST(TsdfVolume, IsCarriedOverToWhereItsPiecesGo) {
  const TsdfVolume volume = scanned(kBox, {0, 0, 0});
  const SE3 rotation = pose_at({0.31, -0.2, 0.12}, 0, 37);
  const std::vector<SurfacePoint> points = half_of(volume, rotation).surface_points();
  EXPECT_NEAR(static_cast<double>(points.size()), static_cast<double>(volume.surface_points().size()) / 2,
              0.1 * static_cast<double>(volume.surface_points().size()));
  double sum = 0;
  for (const SurfacePoint& point : points) {
    const Eigen::Vector3d before = rotation.inverse() * point.position.cast<double>();
    EXPECT_GT(before.x(), -1e-3);
    sum += std::abs(distance_to(kBox, before));
  }
  EXPECT_LT(sum / static_cast<double>(points.size()), 0.001);
}

TEST(TsdfVolume, IsCarriedOverWithTheSameBitsByAnyNumberOfThreads) {
  const TsdfVolume volume = scanned(kSphere, {0, 0, 0}, 1);
  const SE3 rotation = pose_at({0.1, 0, 0}, 20, 10);
  set_thread_count(1);
  const std::vector<SurfacePoint> one = half_of(volume, rotation).surface_points();
  set_thread_count(2);
  const std::vector<SurfacePoint> two = half_of(volume, rotation).surface_points();
  set_thread_count(0);
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) ASSERT_EQ(one[i].position, two[i].position);
}

TEST(TsdfVolume, SurvivesFramesWithoutDepth) {
  TsdfVolume volume(kConfig, {0, 0, 0});
  const Intrinsics camera{16, 12, 20, 20, 8, 6};
  DepthImage nothing(16, 12);
  volume.integrate(fit_depth_planes(nothing, camera), Image<float>(), camera, SE3::Identity());
  for (float& z : nothing.values()) z = std::numeric_limits<float>::quiet_NaN();
  volume.integrate(fit_depth_planes(nothing, camera), Image<float>(), camera, SE3::Identity());
  EXPECT_EQ(volume.brick_count(), 0U);
}

TEST(TsdfVolume, RejectsImpossibleSizes) {
  EXPECT_THROW(TsdfVolume({0, 0.02, 64}, {0, 0, 0}), Error);
  EXPECT_THROW(TsdfVolume({0.01, 0.002, 64}, {0, 0, 0}), Error);
  EXPECT_THROW(TsdfVolume(kConfig, {std::numeric_limits<double>::infinity(), 0, 0}), Error);
  TsdfVolume volume(kConfig, {0, 0, 0});
  const Intrinsics camera{16, 12, 20, 20, 8, 6};
  const DepthPlanes view = fit_depth_planes(DepthImage(16, 12), camera);
  EXPECT_THROW(volume.integrate(view, Image<float>(15, 12), camera, SE3::Identity()), Error);
  SE3 absurd = SE3::Identity();
  absurd.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(volume.integrate(view, Image<float>(), camera, absurd), Error);
}

} // namespace
} // namespace kinora::tracking
