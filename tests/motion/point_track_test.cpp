#include "motion/point_track.h"

#include <gtest/gtest.h>

namespace kinora::motion {
namespace {

SE3 lifted(double y) { return SE3(Eigen::Translation3d(0, y, 0)); }

Motion two_nodes() {
  const auto graph =
      std::make_shared<const DeformationGraph>(std::vector<Eigen::Vector3d>{{0, 0, 1}, {1, 0, 1}}, 0.05, 0.1);
  std::vector<Motion::Deformation> deformations;
  deformations.reserve(3);
  for (int i = 0; i < 3; ++i) {
    deformations.push_back({{DualQuaternion::from(lifted(0.1 * i)), DualQuaternion::from(lifted(-0.1 * i))}});
  }
  return Motion::deforming(graph, std::move(deformations));
}

TEST(PointTrack, APointNearANodeMovesWithIt) {
  const auto track = track_point(two_nodes(), 3, 1, {0.02, 0.1, 1});
  ASSERT_EQ(track.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT((track[static_cast<std::size_t>(i)] - Eigen::Vector3d(0.02, 0.1 * i, 1)).norm(), 1e-3);
  }
}

TEST(PointTrack, APointFarFromAllNodesFollowsTheNearest) {
  const auto track = track_point(two_nodes(), 3, 2, {3, 0, 1});
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT((track[static_cast<std::size_t>(i)] - Eigen::Vector3d(3, 0.2 - 0.1 * i, 1)).norm(), 1e-9);
  }
}

TEST(PointTrack, ARigidLayersPointMovesWithItsPose) {
  const Motion motion = Motion::rigid({{lifted(0), Health::kTracked}, {lifted(0.5), Health::kTracked}});
  const auto track = track_point(motion, 2, 1, {1, 1, 1});
  EXPECT_LT((track[0] - Eigen::Vector3d(1, 0.5, 1)).norm(), 1e-12);
  EXPECT_LT((track[1] - Eigen::Vector3d(1, 1, 1)).norm(), 1e-12);
}

TEST(PointTrack, AStillLayersPointStays) {
  for (const Eigen::Vector3d& position : track_point(Motion::still(), 4, 9, {1, 2, 3})) {
    EXPECT_EQ(position, Eigen::Vector3d(1, 2, 3));
  }
}

TEST(PointTrack, FramesBeyondTheMotionHaveItsLastPlace) {
  const auto track = track_point(two_nodes(), 5, 7, {0, 0.2, 1});
  ASSERT_EQ(track.size(), 5U);
  EXPECT_EQ(track[4], track[2]);
}

} // namespace
} // namespace kinora::motion
