// Deformation graphs: who moves a point, where it goes, and the way back.
#include <gtest/gtest.h>

#include <numbers>

#include "bent_bar.h"
#include "core/random.h"
#include "motion/motion.h"

namespace kinora::motion {
namespace {

Eigen::Vector3d random_point(Random& random, double size) {
  return size * Eigen::Vector3d(random.uniform_double(), random.uniform_double(), random.uniform_double());
}

TEST(NearestPoints, EqualBruteForce) {
  Random random(1);
  std::vector<Eigen::Vector3d> points;
  points.reserve(300);
  for (int i = 0; i < 300; ++i) points.push_back(random_point(random, 1));
  const NearestPoints nearest(points, 0.15);
  for (int k = 0; k < 500; ++k) {
    const Eigen::Vector3d query = random_point(random, 1.2) - Eigen::Vector3d::Constant(0.1);
    std::vector<std::pair<double, int>> all;
    for (int i = 0; i < 300; ++i) {
      const double d = (points[static_cast<std::size_t>(i)] - query).squaredNorm();
      if (d <= 0.15 * 0.15) all.emplace_back(d, i);
    }
    std::sort(all.begin(), all.end());
    std::array<NearestPoints::Neighbour, 5> found{};
    const std::size_t count = nearest.find(query, found);
    ASSERT_EQ(count, std::min<std::size_t>(5, all.size()));
    for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(found[i].index, all[i].second);
  }
}

TEST(DeformationGraph, WeightsAddUpToOneAndAreEmptyFarAway) {
  const BentBar bar(0);
  Random random(2);
  for (int k = 0; k < 200; ++k) {
    const Influence influence = bar.graph->influence(random_point(random, 1));
    double total = 0;
    for (int i = 0; i < influence.count; ++i) total += influence.weights[static_cast<std::size_t>(i)];
    if (influence.count > 0) {
      EXPECT_NEAR(total, 1, 1e-12);
    }
  }
  EXPECT_EQ(bar.graph->influence({0.5, 0.5, 0}).count, 0);
  EXPECT_EQ(bar.graph->influence({std::nan(""), 0, 0}).count, 0);
}

TEST(Warp, RoundTripIsExactToATenthOfAMillimetre) {
  for (const double angle : {0.0, 0.5, 2.0, 3.0}) {
    for (const double far : {0.0, 1000.0}) {
      const Warp warp = BentBar(angle, far).warp();
      Random random(3);
      for (int k = 0; k < 300; ++k) {
        const Eigen::Vector3d canonical(random.uniform_double(), 0.05 * random.uniform_double(),
                                        0.06 * random.uniform_double() - 0.03);
        const auto world = warp.to_world(canonical);
        ASSERT_TRUE(world);
        const auto back = warp.to_canonical(*world);
        ASSERT_TRUE(back) << "angle " << angle << " at " << canonical.transpose();
        EXPECT_LT((*warp.to_world(*back) - *world).norm(), 1.1e-4);
        EXPECT_LT((*back - canonical).norm(), 1e-3);
      }
    }
  }
}

TEST(Warp, IsTheSameWhateverTheSignsOfTheQuaternions) {
  BentBar bar(2.0);
  const Warp warp = bar.warp();
  Random random(4);
  for (DualQuaternion& q : bar.nodes) {
    if (random.below(2) == 0) continue;
    q.real.coeffs() = -q.real.coeffs();
    q.dual.coeffs() = -q.dual.coeffs();
  }
  const Warp mixed = bar.warp();
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector3d p(random.uniform_double(), 0.02, 0.01);
    EXPECT_LT((*warp.to_world(p) - *mixed.to_world(p)).norm(), 1e-9);
  }
}

TEST(Warp, StaysFiniteWhereNeighbouringNodesTurnApartByHalfATurn) {
  BentBar bar(0);
  for (std::size_t i = 0; i < bar.nodes.size(); i += 2) {
    SE3 rotated = SE3::Identity();
    rotated.linear() = Eigen::AngleAxisd(179.9 / 180 * std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix();
    bar.nodes[i] = DualQuaternion::from(rotated);
  }
  const Warp warp = bar.warp();
  Random random(5);
  for (int k = 0; k < 300; ++k) {
    const Eigen::Vector3d p(random.uniform_double(), 0.05 * random.uniform_double(), 0);
    const auto world = warp.to_world(p);
    ASSERT_TRUE(world && world->allFinite());
    EXPECT_LT(world->norm(), 2);
    // At such folds there may be no way back, or several; one that is given leads to the point.
    if (const auto back = warp.to_canonical(*world)) {
      EXPECT_LT((*warp.to_world(*back) - *world).norm(), 1e-3);
      EXPECT_LT((*back - p).norm(), 2);
    }
  }
}

TEST(Motion, OfADeformingLayerGivesEachFrameAndWhatLiesBetween) {
  const BentBar straight(0);
  const BentBar moved(0, 0.2);
  const Motion motion =
      Motion::deforming(straight.graph, {{straight.nodes, Health::kTracked}, {moved.nodes, Health::kHeld}});
  EXPECT_EQ(motion.kind(), MotionKind::kDeforming);
  EXPECT_EQ(motion.health(1), Health::kHeld);
  const Eigen::Vector3d p(0.3, 0.02, 0);
  EXPECT_NEAR(motion.warp(0).to_world(p)->x(), 0.3, 1e-9);
  EXPECT_NEAR(motion.warp(0.25).to_world(p)->x(), 0.35, 1e-9);
  EXPECT_NEAR(motion.warp(9).to_world(p)->x(), 0.5, 1e-9);
  EXPECT_ANY_THROW(motion.canonical_to_world(0));
  EXPECT_ANY_THROW(Motion::deforming(straight.graph, {}));
  EXPECT_ANY_THROW(Motion::deforming(straight.graph, {{{}, Health::kTracked}}));
}

} // namespace
} // namespace kinora::motion
