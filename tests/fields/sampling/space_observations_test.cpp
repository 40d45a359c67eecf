// What pixels that look past a ball say of the space about it.
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "fields/sampling/ray_sampler.h"
#include "fields/sampling/space_observations.h"
#include "fields/sampling/surface_band.h"
#include "fields/scenes/analytic_scene.h"

namespace kinora::fields {
namespace {

constexpr int kBall = 2;

/// A camera that circles the ball, or the ball turning before a camera: the same pictures. They may be read while the
/// camera moves, as if that changed nothing.
struct Views {
  PixelStore store{1'000'000, 12};
  motion::Motion motion = motion::Motion::still();

  explicit Views(bool ball_moves, const Twist& readout = Twist::Zero()) {
    std::vector<motion::Motion::Pose> poses;
    for (int i = 0; i < 12; ++i) {
      ingest::Frame frame = Scene{}.frame(i, 0.05 * (i - 6));
      poses.push_back({frame.camera.camera_to_world.inverse()});
      if (ball_moves) frame.camera.camera_to_world = SE3::Identity();
      store.add(frame, i);
    }
    if (ball_moves) motion = motion::Motion::rigid(poses);
    store.set_readout(std::vector<Twist>(12, readout));
  }
};

class ObservationsOfABall : public ::testing::TestWithParam<bool> {};

TEST_P(ObservationsOfABall, IsEmptyOutsideOfItOnTheRaysOfOtherPixels) {
  const Views views(GetParam());
  const FieldConfig config = choose_field_config({views.store, kBall, views.motion});
  const Occupancy occupancy = RaySampler({views.store, kBall, views.motion}, config, {}).occupancy();
  const SpaceObservations space = observe_occupied_space({views.store, kBall, views.motion}, config, occupancy, 0.05F);
  ASSERT_GT(space.free_space.size(), 1000U);
  EXPECT_TRUE(space.unmeasured.empty());
  const Scene scene;
  for (const RaySegment& segment : space.free_space) {
    const StoredPixel& pixel = views.store.pixels()[segment.pixel];
    ASSERT_NE(pixel.label, kBall);
    ASSERT_LT(segment.segment.begin, segment.segment.end);
    ASSERT_LE(segment.segment.end, free_space_until(pixel));
    const float middle = 0.5F * (segment.segment.begin + segment.segment.end);
    const std::array<float, 3> at = point_at(segment.ray, middle);
    const Eigen::Vector3d canonical = config.box.origin + config.box.side * Eigen::Vector3f(at.data()).cast<double>();
    ASSERT_GT((canonical - scene.centre).norm(), scene.radius);
    const auto frame = std::find_if(views.store.frames().begin(), views.store.frames().end(),
                                    [&](const StoredFrame& f) { return segment.pixel < f.end; });
    const Eigen::Vector3d in_camera =
        frame->camera.camera_to_world.inverse() * (views.motion.canonical_to_world(frame->frame) * canonical);
    const Eigen::Vector3d on_ray = frame->camera.intrinsics.unproject(pixel.u, pixel.v, static_cast<double>(middle));
    ASSERT_LT((in_camera - on_ray).norm(), 1e-5);
  }
}

TEST_P(ObservationsOfABall, AreMadeWhereTheRowThatSeesAPlaceWasRead) {
  const Twist readout = (Twist() << 0.05, -0.03, 0, 0.06, 0.08, -0.02).finished(); // 6 pixels
  const Views views(GetParam(), readout);
  const FieldConfig config = choose_field_config({views.store, kBall, views.motion});
  const Occupancy occupancy = RaySampler({views.store, kBall, views.motion}, config, {}).occupancy();
  const SpaceObservations space = observe_occupied_space({views.store, kBall, views.motion}, config, occupancy, 0.05F);
  ASSERT_GT(space.free_space.size(), 1000U);
  for (const RaySegment& segment : space.free_space) {
    const auto frame = std::find_if(views.store.frames().begin(), views.store.frames().end(),
                                    [&](const StoredFrame& f) { return segment.pixel < f.end; });
    const RowRay ray = frame->ray(views.store.pixels()[segment.pixel]);
    const float middle = 0.5F * (segment.segment.begin + segment.segment.end);
    const std::array<float, 3> at = point_at(segment.ray, middle);
    const Eigen::Vector3d canonical = config.box.origin + config.box.side * Eigen::Vector3f(at.data()).cast<double>();
    const Eigen::Vector3d in_camera =
        frame->camera.camera_to_world.inverse() * (views.motion.canonical_to_world(frame->frame) * canonical);
    ASSERT_LT((in_camera - ray.origin - static_cast<double>(middle) * ray.direction).norm(), 1e-5);
    // The place that was asked for is within the pixel, and it is in the layer's space.
    const Eigen::Array3d in_cells = (canonical - config.box.origin).array() / config.box.side * occupancy.resolution();
    const double pixel = static_cast<double>(middle) / frame->camera.intrinsics.fx;
    const int reach = 1 + static_cast<int>(pixel / config.box.side * occupancy.resolution());
    bool near = false;
    for (int z = -reach; z <= reach && !near; ++z) {
      for (int y = -reach; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x) {
          const Eigen::Array3i cell = in_cells.floor().cast<int>() + Eigen::Array3i(x, y, z);
          if ((cell < 0).any() || (cell >= occupancy.resolution()).any()) continue;
          near = near || occupancy.at(cell.x(), cell.y(), cell.z());
        }
      }
    }
    ASSERT_TRUE(near);
  }
}

INSTANTIATE_TEST_SUITE_P(StillAndRigid, ObservationsOfABall, ::testing::Bool());

} // namespace
} // namespace kinora::fields
