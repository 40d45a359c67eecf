#include "player/subject.h"

#include <gtest/gtest.h>

#include "bake/analytic_field.h"
#include "player/view_path.h"

namespace kinora::player {
namespace {

const Eigen::Vector3d kBall(0.12, 0, -0.25); // metres, of 12 cm radius
constexpr double kWall = 0.4;

/// A ball before a wall, seen by still cameras 90 cm before the ball, each at its own place along x; the optical axis
/// of the middle one passes the ball and meets the wall.
clip::Clip ball_before_wall(const std::vector<double>& camera_xs) {
  clip::Clip clip = bake::testing::sample_clip(static_cast<int>(camera_xs.size()));
  clip.layers.resize(1);
  clip.layers[0].field = bake::testing::field_of(
      [](const Eigen::Vector3d& p) { return std::min((p - kBall).norm() - 0.12, kWall - p.z()); },
      [](const Eigen::Vector3d& p) { return Eigen::Vector3d(0.5, p.z() < 0 ? 0.2 : 0.8, 0.4); });
  clip.camera_to_world.clear();
  for (const double x : camera_xs) clip.camera_to_world.push_back(bake::testing::moved({x, 0, kBall.z() - 0.9}));
  return clip;
}

TEST(StillSubject, IsTheThingBeforeTheWallEvenWhereTheOpticalAxisMeetsTheWall) {
  const Player player(ball_before_wall({-0.03}));
  EXPECT_LT((still_subject(player) - kBall).norm(), 0.15);
}

TEST(StillSubject, IsOnePointForAMovingCamera) {
  const std::vector<double> xs = {-0.3, -0.2, 0.0, 0.2, 0.3};
  const Player player(ball_before_wall(xs));
  const Eigen::Vector3d subject = still_subject(player);
  EXPECT_LT((subject - kBall).norm(), 0.15);
  const std::vector<View> views = orbit_views(player, {0, 1, 2, 3, 4}, 20);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const SE3 from = player.clip().capture_camera(static_cast<int>(i)).camera_to_world.inverse();
    EXPECT_LT((from * subject - views[i].camera.camera_to_world.inverse() * subject).norm(), 1e-9) << i;
  }
}

TEST(StillSubject, IsAheadOfTheCameraWhereNothingIsSeen) {
  clip::Clip clip = ball_before_wall({0});
  clip.camera_to_world[0].linear() = Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitY()).toRotationMatrix();
  const Player player(std::move(clip));
  const Eigen::Vector3d ahead = player.clip().capture_camera(0).camera_to_world * Eigen::Vector3d(0, 0, 2);
  EXPECT_LT((still_subject(player) - ahead).norm(), 1e-9);
}

TEST(Subject, IsTheFirstMovingLayersCentreWhereSomethingMoves) {
  const Player player(bake::testing::sample_clip(3));
  EXPECT_LT((subject_of(player, 2) - player.centre_of(1, 2).value()).norm(), 1e-12);
}

TEST(Subject, IsWhereAMovingLayerIsThereNextWhileItIsAway) {
  clip::Clip clip = bake::testing::sample_clip(5);
  clip.layers[1].presence = motion::Presence::away_during({{0, 2}, {4, 5}});
  const Player player(std::move(clip));
  EXPECT_LT((subject_of(player, 0) - player.centre_of(1, 2).value()).norm(), 1e-12);
  EXPECT_LT((subject_of(player, 4) - player.centre_of(1, 3).value()).norm(), 1e-12);
  const Eigen::Vector3d mean = 0.5 * (player.centre_of(1, 2).value() + player.centre_of(1, 3).value());
  const View first = orbit_views(player, {0, 1, 2, 3, 4}, 30)[1];
  const SE3 from = player.clip().capture_camera(1).camera_to_world.inverse();
  EXPECT_LT((from * mean - first.camera.camera_to_world.inverse() * mean).norm(), 1e-9);
}

} // namespace
} // namespace kinora::player
