// Points find the layer that they lie on.
#include <gtest/gtest.h>

#include "bake/analytic_field.h"
#include "bake/nearest_layer.h"

namespace kinora::bake {
namespace {

TEST(NearestLayer, IsTheOneWhoseSurfaceIsThereAtThatFrame) {
  const clip::Clip clip = testing::sample_clip(4);
  for (const int frame : {0, 3}) {
    std::vector<Eigen::Vector3d> points;
    for (const clip::Layer& layer : clip.layers) {
      const Eigen::Vector3d on_surface = layer.label == 0   ? Eigen::Vector3d(0, 0, 0.05)
                                         : layer.label == 2 ? Eigen::Vector3d(0.3, 0.1, 0)
                                                            : Eigen::Vector3d(-0.3, 0.1, 0);
      points.push_back(layer.motion.warp(frame).to_world(on_surface).value());
    }
    const auto layers = nearest_layers(clip, frame, points, Progress());
    for (std::size_t i = 0; i < layers.size(); ++i) EXPECT_EQ(layers[i], i) << "frame " << frame;
  }
}

TEST(NearestLayer, IsNoneThatIsAwayAtThatFrame) {
  clip::Clip clip = testing::sample_clip(2);
  clip.layers.resize(1);
  clip.layers[0].presence = motion::Presence::away_during({{0, 1}});
  const std::vector<Eigen::Vector3d> points = {{0, 0, 0.05}};
  EXPECT_EQ(nearest_layers(clip, 0, points, Progress())[0], std::nullopt);
  EXPECT_EQ(nearest_layers(clip, 1, points, Progress())[0], 0U);
}

TEST(NearestLayer, IsNoneWhereThereIsNoSurface) {
  clip::Clip clip = testing::sample_clip(1);
  clip.layers = {{"nothing", 0, fields::Field(testing::unit_config()), motion::Motion::still()}};
  const std::vector<Eigen::Vector3d> points = {{0, 0, 0}};
  EXPECT_EQ(nearest_layers(clip, 0, points, Progress())[0], std::nullopt);
}

} // namespace
} // namespace kinora::bake
