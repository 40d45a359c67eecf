#include "tracking/deforming/relocalisation.h"

#include <gtest/gtest.h>

#include "tracking/scenes/plate_layer.h"

namespace kinora::tracking {
namespace {

using testing::frame_of;
using testing::PlateLayer;
using testing::shift;
using testing::small_plate;
using Vec = Eigen::Vector3d;

TEST(Relocalisation, SearchesTheWholeView) {
  const PlateLayer layer(small_plate({-0.15, 0, 1}));
  const LayerView there = view_layer(frame_of(small_plate({0.15, 0.05, 1})), 2);
  const ModelInView now = layer.in(there);
  const motion::NodeStates prior = now.states(layer.moved_by(shift(0, 0, 0)));
  const DeformingSelection selection = now.facing(prior);
  const DeformingAlignment lost = now.align(selection, prior, prior);
  const DeformingAlignment found = Relocalisation::search(now, selection, prior, {}, lost);
  EXPECT_LT(now.facing_inlier_share(lost.nodes), 0.7);
  EXPECT_GT(now.facing_inlier_share(found.nodes), 0.9);
  EXPECT_LT((now.transforms(found.nodes)[5].translation() - Vec(0.3, 0.05, 0)).norm(), 0.01);
}

TEST(Relocalisation, RecallsAPoseThatItHasSeen) {
  const PlateLayer layer(small_plate({0, 0, 1}, 30));
  NodeTrajectory trajectory(0, layer.model.nodes().size(), 0);
  Relocalisation relocalisation;
  relocalisation.add(0, layer.model.origin_to_camera(SE3::Identity()), trajectory);
  // Since then it has turned away; now it is seen as it was at first, somewhere else.
  const SE3 about_centre = shift(0, 0, 1) * testing::pose_at({0, 0, 0}, 0, -70) * shift(0, 0, -1);
  trajectory.add_tracked(layer.moved_by(about_centre), 1);
  const LayerView back = view_layer(frame_of(small_plate({0.1, 0, 1}, 30)), 2);
  const ModelInView now = layer.in(back);
  DeformingAlignment lost;
  lost.nodes = now.states(trajectory.last().nodes);
  const DeformingAlignment found = relocalisation.relocalise(now, trajectory, lost);
  EXPECT_LT(now.facing_inlier_share(lost.nodes), 0.5);
  EXPECT_GT(now.facing_inlier_share(found.nodes), 0.9);
}

TEST(Relocalisation, KeepsWhatExplainsTheViewBetter) {
  const PlateLayer layer(small_plate({0, 0, 1}));
  NodeTrajectory trajectory(0, layer.model.nodes().size(), 0);
  const ModelInView now = layer.in(layer.view);
  DeformingAlignment best;
  best.nodes = now.states(trajectory.last().nodes);
  const DeformingAlignment found = Relocalisation().relocalise(now, trajectory, best);
  EXPECT_EQ(found.nodes.positions, best.nodes.positions);
}

} // namespace
} // namespace kinora::tracking
