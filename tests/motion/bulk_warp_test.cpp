// Many points at once: as Warp has them one by one, and bounded where that has no answer.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "bent_bar.h"
#include "core/error.h"
#include "core/random.h"
#include "motion/bulk_warp.h"
#include "support/every_instruction_set.h"

namespace kinora::motion {
namespace {

using Eigen::Vector3d;

std::array<float, 3> to_array(const Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

Vector3d to_vector(const std::array<float, 3>& v) { return Eigen::Vector3f(v.data()).cast<double>(); }

/// A warp both ways, in coordinates of the spaces themselves.
struct Bulk {
  Warp warp;
  BulkWarp bulk;

  explicit Bulk(const Warp& from, std::shared_ptr<const DeformationGraph> graph)
      : warp(from), bulk(std::make_shared<const InfluenceTable>(std::move(graph)), from) {}
  explicit Bulk(const BentBar& bar) : Bulk(bar.warp(), bar.graph) {}

  std::optional<Vector3d> to_world(const Vector3d& canonical) const {
    const std::array<float, 3> point = to_array(canonical - bulk.canonical_origin());
    BulkWarp::WarpedPoint warped{};
    bulk.to_world({&point, 1}, &warped);
    if (std::isnan(warped.point[0])) return std::nullopt;
    return to_vector(warped.point) + bulk.world_origin();
  }

  struct Back {
    Vector3d point, direction, before, behind;
    Eigen::Matrix3d rotation; // to the world
    Vector3d at(double t) const { return point + t * direction + t * t * (t > 0 ? behind : before); }
  };
  std::optional<Back> to_canonical(const Vector3d& world, const Vector3d& direction, double reach) const {
    BulkWarp::Ray ray{to_array(world - bulk.world_origin()), to_array(direction), static_cast<float>(reach), 0};
    BulkWarp::CanonicalRay back{};
    bulk.to_canonical({&ray, 1}, &back);
    if (std::isnan(back.point[0])) return std::nullopt;
    return Back{to_vector(back.point) + bulk.canonical_origin(), to_vector(back.direction),
                to_vector(back.curvatures[0]), to_vector(back.curvatures[1]),
                Eigen::Quaternionf(back.rotation.data()).cast<double>().toRotationMatrix()};
  }
};

Vector3d random_in_bar(Random& random) {
  return {random.uniform_double(), 0.05 * random.uniform_double(), 0.06 * random.uniform_double() - 0.03};
}

class BulkWarpOnEveryInstructionSet : public OnEveryInstructionSet {};

TEST_P(BulkWarpOnEveryInstructionSet, CarriesPointsAsWarpDoes) {
  Random random(1);
  for (const double angle : {0.0, 2.0}) {
    const Bulk bulk{BentBar(angle)};
    for (int k = 0; k < 2000; ++k) {
      const Vector3d p(1.6 * random.uniform_double() - 0.3, 0.5 * random.uniform_double() - 0.2,
                       0.4 * random.uniform_double() - 0.2);
      const auto wanted = bulk.warp.to_world(p);
      const auto got = bulk.to_world(p);
      ASSERT_EQ(wanted.has_value(), got.has_value()) << p.transpose();
      if (wanted) {
        EXPECT_LT((*wanted - *got).norm(), 2e-5) << p.transpose();
      }
    }
  }
}

TEST_P(BulkWarpOnEveryInstructionSet, TurnsAsWarpDoes) {
  const Bulk bulk{BentBar(2.0)};
  Random random(2);
  for (int k = 0; k < 200; ++k) {
    const Vector3d p = random_in_bar(random);
    const std::array<float, 3> point = to_array(p - bulk.bulk.canonical_origin());
    BulkWarp::WarpedPoint warped{};
    bulk.bulk.to_world({&point, 1}, &warped);
    const Eigen::Matrix3d rotation = Eigen::Quaternionf(warped.rotation.data()).cast<double>().toRotationMatrix();
    EXPECT_LT((rotation - bulk.warp.at(p)->linear()).norm(), 1e-4);
  }
}

TEST_P(BulkWarpOnEveryInstructionSet, WaysBackLeadToTheSamePoint) {
  for (const double angle : {0.0, 0.5, 2.0, 3.0}) {
    for (const double far : {0.0, 1000.0}) {
      const Bulk bulk{BentBar(angle, far)};
      Random random(3);
      for (int k = 0; k < 300; ++k) {
        const Vector3d canonical = random_in_bar(random);
        const Vector3d world = *bulk.warp.to_world(canonical);
        const auto back = bulk.to_canonical(world, Vector3d::UnitZ(), 0.01);
        ASSERT_TRUE(back) << "angle " << angle << " at " << canonical.transpose();
        EXPECT_LT((back->rotation - bulk.warp.at(back->point)->linear()).norm(), 0.02);
        EXPECT_LT((*bulk.warp.to_world(back->point) - world).norm(), 1e-4);
        EXPECT_LT((back->point - canonical).norm(), 1e-3);
      }
    }
  }
}

TEST_P(BulkWarpOnEveryInstructionSet, RaysStayOnTheirLineInTheWorld) {
  const Bulk bulk{BentBar(2.0)};
  Random random(4);
  double largest = 0;
  double straight = 0;
  for (int k = 0; k < 300; ++k) {
    const Vector3d world = *bulk.warp.to_world(random_in_bar(random));
    const Vector3d direction = Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    const auto back = bulk.to_canonical(world, direction, 0.02);
    ASSERT_TRUE(back);
    for (const double t : {-0.02, -0.01, 0.005, 0.015, 0.02}) {
      const auto warped = bulk.warp.to_world(back->at(t));
      ASSERT_TRUE(warped);
      largest = std::max(largest, (*warped - world - t * direction).norm());
      straight = std::max(straight, (*bulk.warp.to_world(back->point + t * direction) - world - t * direction).norm());
    }
  }
  EXPECT_LT(largest, 1e-3);
  EXPECT_GT(straight, 5e-3); // the rays do turn
}

TEST_P(BulkWarpOnEveryInstructionSet, IsTheSameWhateverTheSignsOfTheQuaternions) {
  BentBar bar(2.0);
  const Bulk bulk(bar);
  Random random(5);
  for (DualQuaternion& q : bar.nodes) {
    if (random.below(2) == 0) continue;
    q.real.coeffs() = -q.real.coeffs();
    q.dual.coeffs() = -q.dual.coeffs();
  }
  const Bulk mixed(bar);
  for (int k = 0; k < 200; ++k) {
    const Vector3d p = random_in_bar(random);
    const Vector3d world = *bulk.to_world(p);
    EXPECT_LT((world - *mixed.to_world(p)).norm(), 1e-6);
    EXPECT_LT(
        (bulk.to_canonical(world, Vector3d::UnitZ(), 0)->point - mixed.to_canonical(world, Vector3d::UnitZ(), 0)->point)
            .norm(),
        1e-5);
  }
}

TEST_P(BulkWarpOnEveryInstructionSet, StaysBoundedWhereNeighbouringNodesTurnApartByHalfATurn) {
  BentBar bar(0);
  for (std::size_t i = 0; i < bar.nodes.size(); i += 2) {
    SE3 half_rotated = SE3::Identity();
    half_rotated.linear() = Eigen::AngleAxisd(179.9 / 180 * std::numbers::pi, Vector3d::UnitX()).toRotationMatrix();
    bar.nodes[i] = DualQuaternion::from(half_rotated);
  }
  const Bulk bulk(bar);
  Random random(6);
  int found = 0;
  for (int k = 0; k < 500; ++k) {
    const Vector3d canonical = random_in_bar(random);
    const auto world = bulk.to_world(canonical);
    ASSERT_TRUE(world && world->allFinite());
    EXPECT_LT(world->norm(), 2);
    const auto back = bulk.to_canonical(*world, Vector3d::UnitZ(), 0.02);
    if (!back) continue;
    ++found;
    EXPECT_LT((*bulk.warp.to_world(back->point) - *world).norm(), 1e-3);
    for (const double t : {-0.02, 0.02}) {
      EXPECT_TRUE(back->at(t).allFinite());
      EXPECT_LT((back->at(t) - back->point).norm(), 0.6);
    }
  }
  EXPECT_GT(found, 250);
}

TEST_P(BulkWarpOnEveryInstructionSet, HasNoAnswerFarFromAllNodesOrForWhatIsNoNumber) {
  const Bulk bulk{BentBar(1.0)};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Vector3d& p : {Vector3d(0.5, 0.5, 0), Vector3d(1e9, 0, 0), Vector3d(-1e30, 1e30, 0), Vector3d(nan, 0, 0),
                            Vector3d(0.5, nan, 0), Vector3d(infinity, 0, -infinity)}) {
    EXPECT_FALSE(bulk.to_world(p)) << p.transpose();
    EXPECT_FALSE(bulk.to_canonical(p, Vector3d::UnitZ(), 0.02)) << p.transpose();
  }
  // A direction that is no number spoils no point.
  const Vector3d world = *bulk.to_world({0.5, 0.02, 0});
  const auto back = bulk.to_canonical(world, {nan, 0, 0}, 0.02);
  ASSERT_TRUE(back);
  EXPECT_LT((back->point - Vector3d(0.5, 0.02, 0)).norm(), 1e-3);
}

TEST_P(BulkWarpOnEveryInstructionSet, FollowsASingleNodeRigidly) {
  const auto graph = std::make_shared<const DeformationGraph>(std::vector<Vector3d>{{1, 2, 3}}, 0.05, 0.1);
  SE3 pose = SE3::Identity();
  pose.linear() = Eigen::AngleAxisd(1.0, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  pose.translation() = Vector3d(4, 5, 6);
  const Bulk bulk(Warp(graph, {DualQuaternion::from(pose)}), graph);
  const Vector3d p(1.03, 2.02, 2.96);
  EXPECT_LT((*bulk.to_world(p) - pose * p).norm(), 1e-6);
  const auto back = bulk.to_canonical(pose * p, Vector3d::UnitX(), 0.01);
  ASSERT_TRUE(back);
  EXPECT_LT((back->point - p).norm(), 1e-5);
  EXPECT_LT((back->direction - pose.linear().transpose() * Vector3d::UnitX()).norm(), 1e-5);
}

TEST(BulkWarp, RefusesTheTableOfAnotherGraph) {
  const BentBar bar(0);
  const auto table = std::make_shared<const InfluenceTable>(BentBar(0).graph);
  EXPECT_THROW(BulkWarp(table, bar.warp()), Error);
  EXPECT_THROW(BulkWarp(table, Warp(SE3::Identity())), Error);
}

INSTANTIATE_TEST_SUITE_P(Sets, BulkWarpOnEveryInstructionSet, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::motion
