#include "tracking/camera/pose_graph.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/random.h"
#include "tracking/scenes/synthetic_scene.h"

namespace kinora::tracking {
namespace {

using testing::pose_at;

constexpr double kLever = 2;

PoseEdge edge_between(std::size_t from, std::size_t to, const std::vector<SE3>& poses) {
  return {from, to, poses[from].inverse() * poses[to]};
}

SE3 disturbed(const SE3& pose, double size, Random& random) {
  Twist twist;
  for (int i = 0; i < 6; ++i) twist[i] = size * random.normal();
  return pose * exp_se3(twist);
}

std::vector<SE3> circle(int count) {
  std::vector<SE3> poses;
  for (int i = 0; i < count; ++i) {
    const double angle = 360.0 * i / count;
    poses.push_back(pose_at({0, 0, 0}, 0, angle) * Eigen::Translation3d(0, 0, 1));
  }
  return poses;
}

double total_error(const std::vector<PoseEdge>& edges, const std::vector<SE3>& poses) {
  double sum = 0;
  for (const PoseEdge& edge : edges) sum += edge_error(edge, poses[edge.from], poses[edge.to], kLever).squaredNorm();
  return sum;
}

TEST(PoseGraph, FindsThePosesThatExactEdgesTell) {
  const std::vector<SE3> truth = circle(12);
  std::vector<PoseEdge> edges;
  for (std::size_t i = 0; i < 12; ++i) edges.push_back(edge_between(i, (i + 1) % 12, truth));
  Random random(1, 0);
  std::vector<SE3> poses = truth;
  for (std::size_t i = 1; i < 12; ++i) poses[i] = disturbed(poses[i], 0.1, random);
  optimise_poses(edges, kLever, poses);
  for (std::size_t i = 0; i < 12; ++i) EXPECT_LT((poses[i].matrix() - truth[i].matrix()).norm(), 1e-6) << i;
}

TEST(PoseGraph, SharesADriftAmongThePosesOfALoop) {
  const std::vector<SE3> truth = circle(24);
  Twist drift = Twist::Zero();
  drift[0] = 0.004;
  drift[4] = 0.005;
  std::vector<SE3> poses = {truth[0]};
  std::vector<PoseEdge> edges;
  for (std::size_t i = 0; i + 1 < 24; ++i) {
    PoseEdge edge = edge_between(i, i + 1, truth);
    edge.to_in_from = edge.to_in_from * exp_se3(drift);
    poses.push_back(poses.back() * edge.to_in_from);
    edges.push_back(edge);
  }
  const double open = (poses[23].inverse() * truth[23]).translation().norm();
  edges.push_back(edge_between(23, 0, truth));
  optimise_poses(edges, kLever, poses);
  EXPECT_GT(open, 0.05);
  for (std::size_t i = 0; i < 24; ++i) {
    EXPECT_LT((poses[i].inverse() * truth[i]).translation().norm(), 0.5 * open) << i;
  }
  EXPECT_LT((poses[23].inverse() * truth[23]).translation().norm(), 0.1 * open);
}

TEST(PoseGraph, EndsWhereNoSmallStepOfAnyPoseIsBetter) {
  const std::vector<SE3> truth = circle(6);
  Random random(2, 0);
  std::vector<PoseEdge> edges;
  for (std::size_t a = 0; a < 6; ++a) {
    for (std::size_t b = a + 1; b < 6; ++b) {
      PoseEdge edge = edge_between(a, b, truth);
      edge.to_in_from = disturbed(edge.to_in_from, 0.01, random);
      edges.push_back(edge);
    }
  }
  std::vector<SE3> poses = truth;
  optimise_poses(edges, kLever, poses);
  const double least = total_error(edges, poses);
  EXPECT_LT(least, total_error(edges, truth));
  for (std::size_t p = 1; p < 6; ++p) {
    for (int k = 0; k < 12; ++k) {
      std::vector<SE3> moved = poses;
      moved[p] = poses[p] * exp_se3(Twist::Unit(k / 2) * (k % 2 == 0 ? 1e-3 : -1e-3));
      EXPECT_GT(total_error(edges, moved), least) << p << " " << k;
    }
  }
}

TEST(PoseGraph, AnEdgeOfLittleWeightTakesWhatOthersDisagreeBy) {
  const std::vector<SE3> truth = circle(4);
  std::vector<PoseEdge> edges;
  for (std::size_t i = 0; i < 4; ++i) edges.push_back(edge_between(i, (i + 1) % 4, truth));
  edges[1].to_in_from = edges[1].to_in_from * pose_at({0.3, 0, 0}, 0, 5);
  edges[1].weight = 1e-4;
  std::vector<SE3> poses = truth;
  for (std::size_t i = 2; i < 4; ++i) poses[i] = poses[1] * edges[1].to_in_from * truth[2].inverse() * truth[i];
  optimise_poses(edges, kLever, poses);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((poses[i].matrix() - truth[i].matrix()).norm(), 1e-3) << i;
}

TEST(PoseGraph, LeavesWhatNothingTiesWhereItIs) {
  const std::vector<SE3> truth = circle(4);
  std::vector<SE3> poses = truth;
  optimise_poses(std::vector<PoseEdge>{edge_between(0, 1, truth)}, kLever, poses);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((poses[i].matrix() - truth[i].matrix()).norm(), 1e-9) << i;
}

TEST(PoseGraph, RefusesAnEdgeToNowhere) {
  std::vector<SE3> poses(2, SE3::Identity());
  EXPECT_THROW(optimise_poses(std::vector<PoseEdge>{{0, 2, SE3::Identity()}}, kLever, poses), Error);
}

} // namespace
} // namespace kinora::tracking
