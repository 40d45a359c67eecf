// What pixels that look past a ball say of the space about it.
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "fields/sampling/ray_sampler.h"
#include "fields/sampling/seen_space.h"
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

class SeenSpaceOfABall : public ::testing::TestWithParam<bool> {};

TEST_P(SeenSpaceOfABall, IsEmptyOutsideOfItOnTheRaysOfOtherPixels) {
  const Views views(GetParam());
  const FieldConfig config = choose_field_config({views.store, kBall, views.motion});
  const Occupancy occupancy = RaySampler({views.store, kBall, views.motion}, config, {}).occupancy();
  const SeenSpace space = see_occupied_space({views.store, kBall, views.motion}, config, occupancy, 0.05F);
  ASSERT_GT(space.empty.size(), 1000U);
  EXPECT_TRUE(space.unmeasured.empty());
  const Scene scene;
  for (const SeenPiece& piece : space.empty) {
    const StoredPixel& pixel = views.store.pixels()[piece.pixel];
    ASSERT_NE(pixel.label, kBall);
    ASSERT_LT(piece.piece.begin, piece.piece.end);
    ASSERT_LE(piece.piece.end, empty_until(pixel));
    const float middle = 0.5F * (piece.piece.begin + piece.piece.end);
    const std::array<float, 3> at = point_at(piece.ray, middle);
    const Eigen::Vector3d canonical = config.box.origin + config.box.side * Eigen::Vector3f(at.data()).cast<double>();
    ASSERT_GT((canonical - scene.centre).norm(), scene.radius);
    const auto frame = std::find_if(views.store.frames().begin(), views.store.frames().end(),
                                    [&](const StoredFrame& f) { return piece.pixel < f.end; });
    const Eigen::Vector3d in_camera =
        frame->camera.camera_to_world.inverse() * (views.motion.canonical_to_world(frame->frame) * canonical);
    const Eigen::Vector3d on_ray = frame->camera.intrinsics.unproject(pixel.u, pixel.v, static_cast<double>(middle));
    ASSERT_LT((in_camera - on_ray).norm(), 1e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(StillAndRigid, SeenSpaceOfABall, ::testing::Bool());

} // namespace
} // namespace kinora::fields
