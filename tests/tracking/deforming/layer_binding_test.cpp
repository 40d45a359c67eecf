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
  const ObjectView view = view_object(testing::render_plate({}, kCamera, 0, options), 2);
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
    learn(0, true);
    for (std::size_t frame = 1; frame < kFrames; ++frame) {
      trajectory.add_tracked(std::vector<SE3>(model.nodes().size(), shifted(frame)), static_cast<double>(frame));
      learn(frame, true);
    }
  }

  void learn(std::size_t frame, bool with_thing) {
    const NearbyObject object = thing.at(frame);
    const std::vector<double> seen(model.nodes().size(), 1);
    binding.learn(model, trajectory, seen, std::span(&object, with_thing ? 1 : 0));
  }

  bool is_beside_thing(std::size_t node) const {
    return (model.origin() + model.nodes()[node] - Vec(0.24, 0, 0)).norm() < 0.055;
  }
};

TEST(LayerBinding, PullsNodesToWhereTheObjectTheyHoldHasThem) {
  const Scene scene;
  const NearbyObject object = scene.thing.at(30);
  const NodeTies ties = scene.binding.ties(scene.model, kFrames, SE3::Identity(), {&object, 1});
  ASSERT_EQ(ties.pulls.size(), scene.model.nodes().size());
  int pulled = 0;
  for (std::size_t n = 0; n < ties.pulls.size(); ++n) {
    if (!scene.is_beside_thing(n)) continue;
    ++pulled;
    EXPECT_NEAR(ties.pulls[n].scale, 1 / LayerBindingConfig().holding_sigma, 1e-9);
    EXPECT_LT((ties.pulls[n].place - (scene.model.origin() + shifted(30) * scene.model.nodes()[n])).norm(), 1e-6);
  }
  EXPECT_GT(pulled, 0);
  EXPECT_EQ(ties.edges.size(), scene.model.edges().size());
}

TEST(LayerBinding, PullsNothingWithoutObjectOrBody) {
  const Scene scene;
  const NodeTies ties = scene.binding.ties(scene.model, kFrames, SE3::Identity());
  ASSERT_EQ(ties.pulls.size(), scene.model.nodes().size());
  for (const NodePull& pull : ties.pulls) EXPECT_EQ(pull.scale, 0);
  EXPECT_TRUE(scene.binding.placed_by_bones(scene.model, kFrames).empty());
}

TEST(LayerBinding, MovesWhatItHoldsFromTheFrameThatLastFoundBoth) {
  Scene scene;
  EXPECT_TRUE(scene.binding.motion_of_held(kThing, scene.model, scene.trajectory)->isApprox(SE3::Identity(), 1e-9));
  for (std::size_t frame = kFrames; frame < kFrames + 3; ++frame) {
    scene.trajectory.add_tracked(std::vector<SE3>(scene.model.nodes().size(), shifted(frame)),
                                 static_cast<double>(frame));
    scene.learn(frame, false);
  }
  const auto motion = scene.binding.motion_of_held(kThing, scene.model, scene.trajectory);
  ASSERT_TRUE(motion);
  EXPECT_TRUE(motion->isApprox(shifted(3), 1e-9));
  EXPECT_FALSE(scene.binding.motion_of_held(kThing + 1, scene.model, scene.trajectory));
}

TEST(LayerBinding, SaysNothingOfWhatItHoldsInAFrameThatDoesNotShowTheLayer) {
  Scene scene;
  scene.binding.track({}, kCamera, kFrames, {});
  scene.trajectory.add_untracked(motion::Health::kHeld, kFrames);
  EXPECT_FALSE(scene.binding.motion_of_held(kThing, scene.model, scene.trajectory));
}

} // namespace
} // namespace kinora::tracking
