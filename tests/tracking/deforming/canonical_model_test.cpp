#include "tracking/deforming/canonical_model.h"

#include <gtest/gtest.h>

#include "tracking/scenes/bending_plate.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

testing::SceneOptions small(int occluded_columns = 0) {
  testing::SceneOptions options;
  options.width = 160;
  options.height = 120;
  options.focal = 160;
  options.occluded_columns = occluded_columns;
  return options;
}

LayerView plate_view(int occluded_columns = 0) {
  return view_label(testing::render_plate({}, testing::pose_at({0, 0, -1}, 0, 0), 0, small(occluded_columns)), 2);
}

const SE3 kCamera = testing::pose_at({0, 0, -1}, 0, 0);

CanonicalModel model_of(const LayerView& view) {
  CanonicalModelConfig config;
  config.first_nodes = 80;
  return CanonicalModel::from_view(view, kCamera, config).value();
}

std::vector<SE3> unmoved(const CanonicalModel& model) {
  return std::vector<SE3>(model.nodes().size(), SE3::Identity());
}

GraphGrowth fuse(const LayerView& view, std::size_t frame, CanonicalModel& model) {
  return model.fuse(view, model.states(model.origin_to_camera(kCamera), unmoved(model)), frame);
}

Vec mean_of(std::span<const SurfacePoint> surface) {
  Vec sum = Vec::Zero();
  for (const SurfacePoint& point : surface) sum += point.position.cast<double>();
  return sum / static_cast<double>(surface.size());
}

TEST(CanonicalModel, SpreadsNodesOverTheFirstView) {
  const CanonicalModel model = model_of(plate_view());
  EXPECT_GT(model.nodes().size(), 40U);
  EXPECT_LT(model.nodes().size(), 160U);
  EXPECT_GT(model.edges().size(), 2 * model.nodes().size());
  ASSERT_EQ(model.skin().size(), model.surface().size());
  for (const motion::Influence& influence : model.skin()) EXPECT_GT(influence.count, 0);
  EXPECT_LT((model.origin() + mean_of(model.surface())).norm(), 0.01); // the middle of the plate
}

TEST(CanonicalModel, HasItsGraphInTheWorld) {
  const CanonicalModel model = model_of(plate_view());
  const auto graph = model.graph_in_world();
  ASSERT_EQ(graph->nodes().size(), model.nodes().size());
  EXPECT_LT((graph->nodes()[3] - model.origin() - model.nodes()[3]).norm(), 1e-12);
}

TEST(CanonicalModel, GrowsNodesOnNewSurfaceThatOlderOnesHaveMoved) {
  CanonicalModel model = model_of(plate_view(90));
  const std::size_t first = model.nodes().size();
  const LayerView whole = plate_view();
  std::size_t grown = 0;
  for (std::size_t frame = 1; frame < 12; ++frame) {
    const std::size_t old = model.nodes().size();
    const GraphGrowth growth = fuse(whole, frame, model);
    ASSERT_EQ(model.nodes().size(), old + growth.attached.size() + growth.grown.size());
    for (const motion::Influence& influence : growth.grown) {
      ASSERT_GT(influence.count, 0);
      EXPECT_LT(static_cast<std::size_t>(influence.nodes[0]), old + growth.attached.size());
    }
    for (const std::size_t node : growth.attached) EXPECT_LT(node, model.nodes().size());
    grown += growth.grown.size();
  }
  EXPECT_GT(grown, first / 4);
}

TEST(CanonicalModel, LearnsNothingNewFromTheSameView) {
  const LayerView view = plate_view();
  CanonicalModel model = model_of(view);
  const std::size_t nodes = model.nodes().size();
  for (std::size_t frame = 1; frame < 6; ++frame) fuse(view, frame, model);
  EXPECT_EQ(model.nodes().size(), nodes);
}

TEST(CanonicalModel, TakesItsSurfaceAlongToAnotherPose) {
  const LayerView view = plate_view();
  CanonicalModel model = model_of(view);
  for (std::size_t frame = 1; frame < 4; ++frame) fuse(view, frame, model);
  const Vec before = mean_of(model.surface());
  const auto points = static_cast<double>(model.surface().size());
  const std::vector<Vec> nodes = model.nodes();
  SE3 motion(Eigen::AngleAxisd(0.5, Vec::UnitY()));
  motion.translation() = Vec(0.1, 0.05, 0);
  model.set_canonical_pose(std::vector<SE3>(nodes.size(), motion));
  EXPECT_LT((model.nodes()[5] - motion * nodes[5]).norm(), 1e-12);
  EXPECT_LT((mean_of(model.surface()) - motion * before).norm(), 0.005);
  // A plane that is turned crosses more edges between voxels.
  EXPECT_GT(static_cast<double>(model.surface().size()), 0.9 * points);
  EXPECT_LT(static_cast<double>(model.surface().size()), 1.5 * points);
  EXPECT_GT(model.edges().size(), 2 * nodes.size());
}

} // namespace
} // namespace kinora::tracking
