#include "tracking/deforming/node_trajectory.h"

#include <gtest/gtest.h>

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

const std::vector<Vec> kCanonical = {{0, 0, 0}, {0.1, 0, 0}};

std::vector<SE3> both_at(double x) { return {2, SE3(Eigen::Translation3d(x, 0, 0))}; }

motion::Influence half_way() {
  motion::Influence influence;
  influence.count = 2;
  influence.nodes = {0, 1};
  influence.weights = {0.5, 0.5};
  return influence;
}

TEST(NodeTrajectory, BeginsWhereTheNodesAreInCanonicalSpace) {
  const NodeTrajectory trajectory(3, 2, 0.1);
  EXPECT_EQ(trajectory.first(), 3U);
  EXPECT_EQ(trajectory.frame_count(), 4U);
  EXPECT_EQ(trajectory.at(3).health, motion::Health::kTracked);
  ASSERT_EQ(trajectory.last().nodes.size(), 2U);
  EXPECT_TRUE(trajectory.last().nodes[1].isApprox(SE3::Identity()));
}

TEST(NodeTrajectory, ExpectsMostOfTheLastMotionAgain) {
  NodeTrajectory trajectory(0, 2, 0);
  EXPECT_DOUBLE_EQ(trajectory.predicted(kCanonical, 1, 0.8)[0].translation().x(), 0);
  trajectory.add_tracked(both_at(0.01), 1);
  EXPECT_NEAR(trajectory.predicted(kCanonical, 2, 0.8)[1].translation().x(), 0.018, 1e-12);
  EXPECT_NEAR(trajectory.predicted(kCanonical, 3, 0.8)[1].translation().x(), 0.026, 1e-12);
}

TEST(NodeTrajectory, ExpectsNoMotionAfterAFrameThatDidNotShowIt) {
  NodeTrajectory trajectory(0, 2, 0);
  trajectory.add_tracked(both_at(0.01), 1);
  trajectory.add_untracked(motion::Health::kHeld, 2);
  EXPECT_DOUBLE_EQ(trajectory.predicted(kCanonical, 3, 0.8)[0].translation().x(), 0.01);
  trajectory.add_tracked(both_at(0.05), 3);
  EXPECT_DOUBLE_EQ(trajectory.predicted(kCanonical, 4, 0.8)[0].translation().x(), 0.05);
}

TEST(NodeTrajectory, StaysWhereItIsWhileItIsNotTracked) {
  NodeTrajectory trajectory(0, 2, 0);
  trajectory.add_tracked(both_at(0.01), 1);
  trajectory.add_untracked(motion::Health::kLost, 2);
  EXPECT_EQ(trajectory.last().health, motion::Health::kLost);
  EXPECT_DOUBLE_EQ(trajectory.last().nodes[0].translation().x(), 0.01);
}

TEST(NodeTrajectory, GivesNewNodesThePastOfOlderOnes) {
  NodeTrajectory trajectory(0, 2, 0);
  trajectory.add_tracked({SE3(Eigen::Translation3d(0.1, 0, 0)), SE3(Eigen::Translation3d(0.3, 0, 0))}, 1);
  trajectory.add_tracked(both_at(0.4), 2);
  trajectory.add_nodes({{1}, {half_way()}});
  ASSERT_EQ(trajectory.at(1).nodes.size(), 4U);
  EXPECT_EQ(trajectory.at(1).nodes[2].matrix(), trajectory.at(1).nodes[1].matrix());
  EXPECT_NEAR(trajectory.at(1).nodes[3].translation().x(), 0.2, 1e-12);
  EXPECT_TRUE(trajectory.is_extrapolated(2, 1));
  EXPECT_FALSE(trajectory.is_extrapolated(2, 2));
  EXPECT_FALSE(trajectory.is_extrapolated(0, 0));
  EXPECT_EQ(trajectory.first_without_extrapolation(), 2U);
}

TEST(NodeTrajectory, DoubtsThePastOfANode) {
  NodeTrajectory trajectory(0, 2, 0);
  trajectory.add_tracked(both_at(0.1), 1);
  EXPECT_EQ(trajectory.first_without_extrapolation(), 0U);
  trajectory.mark_past_extrapolated(1);
  EXPECT_TRUE(trajectory.is_extrapolated(1, 0));
  EXPECT_FALSE(trajectory.is_extrapolated(0, 0));
}

TEST(NodeTrajectory, MovesNothingInTheWorldWhenTheCanonicalPoseIsAnother) {
  NodeTrajectory trajectory(0, 2, 0);
  SE3 bent(Eigen::AngleAxisd(0.4, Vec::UnitY()));
  bent.translation() = Vec(0.2, 0.1, 0);
  trajectory.add_tracked({bent, SE3(Eigen::Translation3d(0.3, 0, 0))}, 1);
  const Vec before = trajectory.at(1).nodes[0] * kCanonical[0];
  const std::vector<SE3> pose = trajectory.at(1).nodes;
  trajectory.set_canonical_pose(pose);
  EXPECT_TRUE(trajectory.at(1).nodes[0].isApprox(SE3::Identity(), 1e-12));
  EXPECT_LT((trajectory.at(1).nodes[0] * (pose[0] * kCanonical[0]) - before).norm(), 1e-12);
  EXPECT_LT((trajectory.at(0).nodes[1] * (pose[1] * kCanonical[1]) - kCanonical[1]).norm(), 1e-12);
}

TEST(NodeTrajectory, TellsOfAllFramesOfTheCapture) {
  NodeTrajectory trajectory(2, 2, 0);
  trajectory.add_tracked(both_at(0.5), 1);
  trajectory.add_untracked(motion::Health::kHeld, 2);
  const auto deformations = trajectory.deformations({7, 0, 0});
  ASSERT_EQ(deformations.size(), 5U);
  EXPECT_EQ(deformations[0].health, motion::Health::kLost);
  EXPECT_EQ(deformations[2].health, motion::Health::kTracked);
  EXPECT_EQ(deformations[4].health, motion::Health::kHeld);
  EXPECT_LT(deformations[0].node_to_world[0].to_se3().translation().norm(), 1e-12);
  EXPECT_LT((deformations[4].node_to_world[1].to_se3() * Vec(7, 1, 1) - Vec(7.5, 1, 1)).norm(), 1e-9);
}

} // namespace
} // namespace kinora::tracking
