#include "tracking/model/brick_influences.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "tracking/scenes/scanned_sphere.h"

namespace kinora::tracking {
namespace {

using testing::scanned_sphere;

void add_nodes_near(const TsdfVolume& volume, std::size_t count, Random& random, std::vector<Eigen::Vector3d>& nodes) {
  const std::vector<SurfacePoint> surface = volume.surface_points();
  for (std::size_t i = 0; i < count; ++i) {
    nodes.push_back(surface[random.below(static_cast<std::uint32_t>(surface.size()))].position.cast<double>() +
                    0.02 * Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
  }
}

void expect_those_of_the_graph(const BrickInfluences& influences, const TsdfVolume& volume,
                               const motion::DeformationGraph& graph, Random& random) {
  for (std::size_t brick = 0; brick < volume.brick_count(); ++brick) {
    motion::PointLanes points{};
    for (std::size_t i = 0; i < motion::PointLanes::kPoints; ++i) {
      const Eigen::Vector3d inside(random.uniform_double() - 0.5, random.uniform_double() - 0.5,
                                   random.uniform_double() - 0.5);
      points.set(i, (volume.brick_centre(brick) + volume.brick_size() * inside).cast<float>());
    }
    motion::InfluenceLanes lanes;
    influences.skinning_weights_of(brick, points, lanes);
    for (std::size_t i = 0; i < motion::PointLanes::kPoints; ++i) {
      const motion::Influence expected = graph.influence(points.at(i).cast<double>());
      const motion::Influence found = lanes.at(i);
      ASSERT_EQ(found.count > 0, expected.count > 0);
      for (std::size_t k = 0; k < motion::Influence::kMax; ++k)
        EXPECT_NEAR(found.weights[k], expected.weights[k], 1e-4);
    }
  }
}

TEST(BrickInfluences, AreThoseOfTheGraphAlsoAfterItHasGrown) {
  Random random(8);
  const TsdfVolume volume = scanned_sphere();
  ASSERT_GT(volume.brick_count(), 20U);
  std::vector<Eigen::Vector3d> nodes;
  BrickInfluences influences;
  for (const std::size_t more : {40U, 1U, 0U, 25U}) {
    add_nodes_near(volume, more, random, nodes);
    const auto graph = std::make_shared<const motion::DeformationGraph>(nodes, 0.03, 0.07);
    influences.update(volume, graph);
    expect_those_of_the_graph(influences, volume, *graph, random);
  }
}

TEST(BrickInfluences, ABrickNewerThanTheRenewalIsSearchedFor) {
  const auto graph =
      std::make_shared<const motion::DeformationGraph>(std::vector<Eigen::Vector3d>{{0, 0, 0}}, 0.03, 0.07);
  BrickInfluences influences;
  influences.update(TsdfVolume({0.006, 0.03, 64}, Eigen::Vector3d::Zero()), graph);
  motion::PointLanes points{};
  points.set(0, {0.01F, 0, 0});
  points.set(1, {0.1F, 0, 0});
  motion::InfluenceLanes lanes;
  influences.skinning_weights_of(3, points, lanes);
  EXPECT_EQ(lanes.at(0).count, 1);
  EXPECT_EQ(lanes.at(1).count, 0);
}

} // namespace
} // namespace kinora::tracking
