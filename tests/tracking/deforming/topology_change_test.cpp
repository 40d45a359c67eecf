#include "tracking/deforming/topology_change.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

constexpr int kAlong = 6;
constexpr std::size_t kSheet = kAlong * kAlong;
constexpr double kSpacing = 0.04;

/// Two sheets of nodes; edges within each, and between nodes that face each other.
struct Sheets {
  std::vector<Vec> nodes;
  std::vector<GraphEdge> edges;

  explicit Sheets(double gap) {
    for (std::size_t i = 0; i < 2 * kSheet; ++i) {
      const auto number = static_cast<int>(i);
      const int u = number % kAlong;
      const int v = number / kAlong % kAlong;
      nodes.emplace_back(kSpacing * u, kSpacing * v, i < kSheet ? 0.0 : gap);
      if (u > 0) edges.push_back({number - 1, number});
      if (v > 0) edges.push_back({number - kAlong, number});
      if (i >= kSheet) edges.push_back({number - static_cast<int>(kSheet), number});
    }
  }
};

// The second sheet, moved.
std::vector<SE3> moved_by(double metres) {
  std::vector<SE3> poses(2 * kSheet, SE3::Identity());
  std::fill(poses.begin() + kSheet, poses.end(), SE3(Eigen::Translation3d(0, 0, metres)));
  return poses;
}

const std::vector<double> kSeen(2 * kSheet, 1);

TEST(TopologyChange, FindsSurfacesThatTouchedAndHaveParted) {
  const Sheets sheets(kSpacing);
  const auto separated = find_separated_nodes(sheets.nodes, kSpacing, moved_by(0.2), moved_by(0.3), kSeen);
  for (std::size_t n = 0; n < 2 * kSheet; ++n) {
    EXPECT_NE(std::find(separated.begin(), separated.end(), n), separated.end()) << n;
  }
}

TEST(TopologyChange, WaitsForASecondFrame) {
  EXPECT_TRUE(find_separated_nodes(Sheets(kSpacing).nodes, kSpacing, moved_by(0), moved_by(0.3), kSeen).empty());
}

TEST(TopologyChange, LearnsNothingFromWhatIsHidden) {
  const std::vector<double> hidden(2 * kSheet, 0);
  EXPECT_TRUE(find_separated_nodes(Sheets(kSpacing).nodes, kSpacing, moved_by(0.3), moved_by(0.3), hidden).empty());
}

TEST(TopologyChange, KeepsAPoseInWhichMoreIsApart) {
  EXPECT_TRUE(find_separated_nodes(Sheets(0.3).nodes, kSpacing, moved_by(-0.26), moved_by(-0.26), kSeen).empty());
}

TEST(TopologyChange, PosesPartedSurfacesApart) {
  const Sheets sheets(kSpacing);
  const std::vector<SE3> pose = separated_pose(sheets.nodes, sheets.edges, moved_by(0.3));
  for (std::size_t n = 0; n < 2 * kSheet; ++n) {
    EXPECT_LT((pose[n] * sheets.nodes[n] - moved_by(0.3)[n] * sheets.nodes[n]).norm(), 1e-3) << n;
  }
}

} // namespace
} // namespace kinora::tracking
