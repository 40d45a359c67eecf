#include "tracking/deforming/block_matching.h"

#include <gtest/gtest.h>

#include "tracking/scenes/bending_plate.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

testing::Plate plate_at(double x) {
  testing::Plate plate;
  plate.to_world.translation() = Vec(x, 0, 1.2);
  return plate;
}

LayerView view_of(const testing::Plate& plate) {
  testing::SceneOptions options;
  options.noise = 1;
  return view_label(testing::render_plate(plate, SE3::Identity(), 0, options), 2);
}

/// A grid of nodes over the plate's middle, and edges along its rows.
struct Nodes {
  motion::NodeStates states;
  std::vector<GraphEdge> edges;
};

Nodes nodes_on(const testing::Plate& plate) {
  Nodes nodes;
  for (const double y : {-0.08, 0.0, 0.08}) {
    for (const double x : {-0.12, -0.06, 0.0, 0.06, 0.12}) {
      const SE3 position(Eigen::Translation3d(plate.position(x, y)));
      nodes.states.push_back(DualQuaternion::from(position), Vec::Zero());
      const int last = static_cast<int>(nodes.states.size()) - 1;
      if (last % 5 != 0) nodes.edges.push_back({last - 1, last});
      if (last >= 5) nodes.edges.push_back({last - 5, last});
    }
  }
  return nodes;
}

// Depth says nothing of it.
TEST(NodeFlow, FindsHowFarAPlateSlidAlongItself) {
  const Nodes before = nodes_on(plate_at(0));
  const auto flow =
      match_blocks(view_of(plate_at(0)), before.states, view_of(plate_at(0.06)), before.states, before.edges);
  ASSERT_EQ(flow.size(), before.states.size());
  for (const Vec& step : flow) EXPECT_LT((step - Vec(0.06, 0, 0)).norm(), 0.01);
}

TEST(NodeFlow, LeavesNodesThatAreWhereTheyAreExpected) {
  const Nodes before = nodes_on(plate_at(0));
  const Nodes after = nodes_on(plate_at(0.06));
  const auto flow =
      match_blocks(view_of(plate_at(0)), before.states, view_of(plate_at(0.06)), after.states, before.edges);
  for (const Vec& step : flow) EXPECT_EQ(step, Vec(Vec::Zero()));
}

} // namespace
} // namespace kinora::tracking
