#include "tracking/model/arap_deformation.h"

#include <gtest/gtest.h>

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

constexpr int kAlong = 8;

/// Two sheets of 8 × 8 nodes, 4 cm apart each; edges within the sheets alone.
struct Sheets {
  std::vector<Vec> nodes;
  std::vector<GraphEdge> edges;

  Sheets() {
    for (int i = 0; i < 2 * kAlong * kAlong; ++i) {
      const int u = i % kAlong;
      const int v = i / kAlong % kAlong;
      nodes.emplace_back(0.04 * u, 0.04 * v, i < kAlong * kAlong ? 0.0 : 0.04);
      if (u > 0) edges.push_back({i - 1, i});
      if (v > 0) edges.push_back({i - kAlong, i});
      if (u > 0 && v > 0) edges.push_back({i - kAlong - 1, i});
    }
  }
};

SE3 motion_of(std::size_t node) {
  SE3 motion = SE3::Identity();
  if (node < kAlong * kAlong) return motion;
  motion.linear() = Eigen::AngleAxisd(1.2, Vec(1, -2, 0.5).normalized()).toRotationMatrix();
  motion.translation() = Vec(0.3, 0.1, -0.2);
  return motion;
}

TEST(ArapDeform, LeavesPartsThatHaveMovedAsRigidBodiesWhereTheyAre) {
  const Sheets sheets;
  std::vector<SE3> targets;
  for (std::size_t n = 0; n < sheets.nodes.size(); ++n) targets.push_back(motion_of(n));
  const std::vector<SE3> pose = arap_deform(sheets.nodes, sheets.edges, targets, 0.3);
  for (std::size_t n = 0; n < pose.size(); ++n) {
    EXPECT_LT((pose[n] * sheets.nodes[n] - targets[n] * sheets.nodes[n]).norm(), 1e-9) << n;
    EXPECT_LT((pose[n].linear() - targets[n].linear()).norm(), 1e-6) << n;
  }
}

TEST(ArapDeform, BringsBackANodeThatWasLeftBehind) {
  const Sheets sheets;
  constexpr std::size_t kLeft = kAlong * kAlong + 3 * kAlong + 4;
  std::vector<SE3> targets;
  for (std::size_t n = 0; n < sheets.nodes.size(); ++n) targets.push_back(motion_of(n == kLeft ? 0 : n));
  const std::vector<SE3> pose = arap_deform(sheets.nodes, sheets.edges, targets, 0.3);
  const Vec truth = motion_of(kLeft) * sheets.nodes[kLeft];
  const double behind = (sheets.nodes[kLeft] - truth).norm();
  EXPECT_GT(behind, 0.1);
  EXPECT_LT((pose[kLeft] * sheets.nodes[kLeft] - truth).norm(), 0.2 * behind);
}

TEST(ArapDeform, KeepsANodeWithoutNeighboursAsItIs) {
  const std::vector<Vec> nodes = {{0.1, 0.2, 0.3}};
  const std::vector<SE3> targets = {motion_of(kAlong * kAlong)};
  const std::vector<SE3> pose = arap_deform(nodes, {}, targets, 0.3);
  EXPECT_LT((pose[0].matrix() - targets[0].matrix()).norm(), 1e-9);
}

} // namespace
} // namespace kinora::tracking
