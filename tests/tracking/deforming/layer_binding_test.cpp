#include "tracking/deforming/layer_binding.h"

#include <gtest/gtest.h>

#include "tracking/scenes/bending_plate.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

constexpr int kThing = 7;
constexpr std::size_t kFrames = 10;

const SE3 kCamera = testing::pose_at({0, 0, -1}, 0, 0);

CanonicalModel plate_model() {
  testing::SceneOptions options;
  options.width = 160;
  options.height = 120;
  options.focal = 160;
  const LayerView view = view_label(testing::render_plate({}, kCamera, 0, options), 2);
  CanonicalModelConfig config;
  config.first_nodes = 80;
  return CanonicalModel::from_view(view, kCamera, config).value();
}

SE3 shifted(std::size_t frame) { return SE3(Eigen::Translation3d(0.01 * static_cast<double>(frame), 0, 0)); }

/// A thing of one point at the plate's right edge, which goes along with it.
struct HeldThing {
  std::vector<SurfacePoint> surface{{Eigen::Vector3f::Zero(), Eigen::Vector3f::UnitZ(), 0, 1}};

  NearbyObject at(std::size_t frame) const {
    return {kThing, shifted(frame) * Eigen::Translation3d(0.24, 0, 0), surface, Vec::Zero()};
  }
};

/// A plate that moves, and what it has learnt of the thing.
struct Scene {
  HeldThing thing;
  CanonicalModel model = plate_model();
  NodeTrajectory trajectory{0, model.nodes().size(), 0};
  LayerBinding binding;

  Scene() {
    update(0, true);
    for (std::size_t frame = 1; frame < kFrames; ++frame) {
      trajectory.add_tracked(std::vector<SE3>(model.nodes().size(), shifted(frame)), static_cast<double>(frame));
      update(frame, true);
    }
  }

  void update(std::size_t frame, bool with_thing) {
    const NearbyObject object = thing.at(frame);
    const std::vector<double> seen(model.nodes().size(), 1);
    binding.update(model, trajectory, seen, std::span(&object, with_thing ? 1 : 0));
  }

  bool is_beside_thing(std::size_t node) const {
    return (model.origin() + model.nodes()[node] - Vec(0.24, 0, 0)).norm() < 0.055;
  }
};

TEST(LayerBinding, PullsNodesToWhereTheObjectTheyHoldHasThem) {
  const Scene scene;
  const NearbyObject object = scene.thing.at(30);
  const NodeConstraints constraints = scene.binding.constraints(scene.model, kFrames, SE3::Identity(), {&object, 1});
  ASSERT_EQ(constraints.targets.size(), scene.model.nodes().size());
  int targeted = 0;
  for (std::size_t n = 0; n < constraints.targets.size(); ++n) {
    if (!scene.is_beside_thing(n)) continue;
    ++targeted;
    EXPECT_NEAR(constraints.targets[n].scale, 1 / LayerBindingConfig().contact_sigma, 1e-9);
    EXPECT_LT((constraints.targets[n].position - (scene.model.origin() + shifted(30) * scene.model.nodes()[n])).norm(),
              1e-6);
  }
  EXPECT_GT(targeted, 0);
  EXPECT_EQ(constraints.edges.size(), scene.model.edges().size());
}

TEST(LayerBinding, PullsNothingWithoutObjectOrBody) {
  const Scene scene;
  const NodeConstraints constraints = scene.binding.constraints(scene.model, kFrames, SE3::Identity());
  ASSERT_EQ(constraints.targets.size(), scene.model.nodes().size());
  for (const NodeTarget& target_weight : constraints.targets) EXPECT_EQ(target_weight.scale, 0);
  EXPECT_TRUE(scene.binding.bone_driven_nodes(scene.model, kFrames).empty());
}

TEST(LayerBinding, MovesWhatItHoldsFromTheFrameThatLastFoundBoth) {
  Scene scene;
  EXPECT_TRUE(scene.binding.contact_motion(kThing, scene.model, scene.trajectory)->isApprox(SE3::Identity(), 1e-9));
  for (std::size_t frame = kFrames; frame < kFrames + 3; ++frame) {
    scene.trajectory.add_tracked(std::vector<SE3>(scene.model.nodes().size(), shifted(frame)),
                                 static_cast<double>(frame));
    scene.update(frame, false);
  }
  const auto motion = scene.binding.contact_motion(kThing, scene.model, scene.trajectory);
  ASSERT_TRUE(motion);
  EXPECT_TRUE(motion->isApprox(shifted(3), 1e-9));
  EXPECT_FALSE(scene.binding.contact_motion(kThing + 1, scene.model, scene.trajectory));
}

TEST(LayerBinding, SaysNothingOfWhatItHoldsInAFrameThatDoesNotShowTheLayer) {
  Scene scene;
  scene.binding.track({}, kCamera, kFrames, {});
  scene.trajectory.add_untracked(motion::Health::kHeld, kFrames);
  EXPECT_FALSE(scene.binding.contact_motion(kThing, scene.model, scene.trajectory));
}

} // namespace
} // namespace kinora::tracking
