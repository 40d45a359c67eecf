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

/// A camera that circles the ball, or the ball turning before a camera: the same pictures.
struct Views {
  PixelStore store{1'000'000, 12};
  motion::Motion motion = motion::Motion::still();

  explicit Views(bool ball_moves) {
    std::vector<motion::Motion::Pose> poses;
    for (int i = 0; i < 12; ++i) {
      ingest::Frame frame = Scene{}.frame(i, 0.05 * (i - 6));
      poses.push_back({frame.camera.camera_to_world.inverse()});
      if (ball_moves) frame.camera.camera_to_world = SE3::Identity();
      store.add(frame, i);
    }
    if (ball_moves) motion = motion::Motion::rigid(poses);
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

INSTANTIATE_TEST_SUITE_P(StillAndRigid, ObservationsOfABall, ::testing::Bool());

} // namespace
} // namespace kinora::fields
