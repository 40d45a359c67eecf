#include "player/view_path.h"

#include <numbers>

#include <gtest/gtest.h>

#include "clip/sample_clip.h"

namespace kinora::player {
namespace {

Camera some_camera() {
  Camera camera{{640, 480, 500, 500, 319.5, 239.5}, SE3::Identity()};
  camera.camera_to_world.translate(Eigen::Vector3d(0.3, -0.2, 1));
  camera.camera_to_world.rotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 0.5).normalized()));
  return camera;
}

TEST(Orbit, PositiveAnglesGoToTheCamerasRight) {
  const Camera camera = some_camera();
  const Eigen::Vector3d pivot = camera.camera_to_world * Eigen::Vector3d(0, 0, 2);
  const Camera moved = orbited(camera, pivot, 0.3);
  const Eigen::Vector3d seen_before = camera.camera_to_world.inverse() * moved.camera_to_world.translation();
  EXPECT_NEAR(seen_before.x(), 2 * std::sin(0.3), 1e-12);
  EXPECT_NEAR(seen_before.y(), 0, 1e-12);
  EXPECT_NEAR(seen_before.z(), 2 - 2 * std::cos(0.3), 1e-12);
}

TEST(Orbit, PivotStaysAtItsPixelAndDistance) {
  const Camera camera = some_camera();
  const Eigen::Vector3d pivot = camera.camera_to_world * Eigen::Vector3d(0.3, -0.1, 2);
  const Eigen::Vector3d before = camera.camera_to_world.inverse() * pivot;
  for (const double angle : {-3.0, -0.5, 0.7, 3.1}) {
    const Eigen::Vector3d after = orbited(camera, pivot, angle).camera_to_world.inverse() * pivot;
    EXPECT_LT((after - before).norm(), 1e-12);
  }
}

class OrbitOfClip : public testing::Test {
protected:
  OrbitOfClip() : player_(clip::testing::sample_clip(3, 8, false)) {}
  Player player_;

  // Of the view, relative to the capture camera, in degrees.
  double angle_of(const View& view) const {
    const SE3 turn = player_.clip().capture_camera(view.frame).camera_to_world.inverse() * view.camera.camera_to_world;
    return rotation_angle(turn) * 180 / std::numbers::pi;
  }
};

TEST_F(OrbitOfClip, SingleFrameIsSeenFromTheWholeAngle) {
  const auto views = orbit_views(player_, {5}, 30);
  ASSERT_EQ(views.size(), 1U);
  EXPECT_EQ(views[0].frame, 5);
  EXPECT_NEAR(angle_of(views[0]), 30, 1e-9);
}

TEST_F(OrbitOfClip, FilmSwingsToBothSidesAndStartsAtTheCapture) {
  const auto views = orbit_views(player_, {0, 1, 2, 3, 4, 5, 6, 7}, 20);
  ASSERT_EQ(views.size(), 8U);
  EXPECT_NEAR(angle_of(views[0]), 0, 1e-6);
  EXPECT_NEAR(angle_of(views[2]), 20, 1e-9);
  EXPECT_NEAR(angle_of(views[6]), 20, 1e-9);
  const SE3 both = views[2].camera.camera_to_world.inverse() * views[6].camera.camera_to_world;
  EXPECT_NEAR(rotation_angle(both) * 180 / std::numbers::pi, 40, 1e-9);
}

TEST_F(OrbitOfClip, TurnsAboutTheMovingLayersCentre) {
  const auto views = orbit_views(player_, {4}, 25);
  const Eigen::Vector3d centre = player_.centre_of(1, 4).value();
  const Eigen::Vector3d before = player_.clip().capture_camera(4).camera_to_world.inverse() * centre;
  const Eigen::Vector3d after = views[0].camera.camera_to_world.inverse() * centre;
  EXPECT_LT((after - before).norm(), 1e-9);
}

TEST(CaptureView, FollowsTheCamerasPathWithFrameNumbersAsNames) {
  const clip::Clip clip = clip::testing::sample_clip(4, 5, true);
  const auto views = capture_views(clip, {1, 4});
  ASSERT_EQ(views.size(), 2U);
  EXPECT_EQ(views[1].name, "000004");
  EXPECT_TRUE(views[1].camera.camera_to_world.isApprox(clip.camera_to_world[4], 1e-12));
  EXPECT_EQ(views[1].camera.intrinsics, clip.intrinsics);
}

} // namespace
} // namespace kinora::player
