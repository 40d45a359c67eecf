#include "tracking/deforming/body_binding.h"

#include <utility>

#include <gtest/gtest.h>

#include "tracking/body/synthetic_body.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

constexpr std::array<LimbHealth, kLimbs> kAllSeen = {LimbHealth::kSeen, LimbHealth::kSeen, LimbHealth::kSeen,
                                                     LimbHealth::kSeen};

PosedBody somebody(double bend) {
  BodyState state = testing::standing(0);
  state.pose.angles[joints()[kLeftElbow].first_angle] += bend;
  return pose_body(state.pose, state.shape);
}

const std::vector<double> kUnseen(4, 0);

/// A node on the left forearm, one on the head, one beside nobody.
std::vector<SE3> three_nodes(const PosedBody& body) {
  const auto at = [](double x, double y, double z) { return SE3(Eigen::Translation3d(x, y, z)); };
  return {body.bones[kLeftElbow] * at(0.13, 0, 0.04), body.bones[kHead] * at(0, 0.1, 0.1),
          body.bones[kHead] * at(0, 0.6, 0)};
}

std::vector<Vec> three_places(const PosedBody& body) {
  std::vector<Vec> places;
  for (const SE3& node : three_nodes(body)) places.emplace_back(node.translation());
  return places;
}

TEST(BodyBinding, CarriesANodeWithItsBone) {
  const PosedBody straight = somebody(0);
  const PosedBody bent = somebody(1);
  BodyBinding binding;
  binding.bind(straight, three_nodes(straight), kUnseen);
  EXPECT_GT((three_places(bent)[0] - three_places(straight)[0]).norm(), 0.05);
  for (const std::size_t n : {0U, 1U}) {
    const auto place = binding.place_of(n, bent.bones);
    ASSERT_TRUE(place);
    EXPECT_LT((*place - three_places(bent)[n]).norm(), 1e-9) << n;
  }
  EXPECT_FALSE(binding.place_of(2, bent.bones));
}

TEST(BodyBinding, BindsOnlyNodesThatAreNew) {
  const PosedBody straight = somebody(0);
  const PosedBody bent = somebody(1);
  BodyBinding binding;
  std::vector<SE3> nodes = three_nodes(straight);
  binding.bind(straight, nodes, kUnseen);
  nodes.push_back(three_nodes(bent)[0]);
  binding.bind(bent, nodes, kUnseen);
  EXPECT_LT((*binding.place_of(0, straight.bones) - nodes[0].translation()).norm(), 1e-9);
  EXPECT_LT((*binding.place_of(3, straight.bones) - nodes[0].translation()).norm(), 1e-9);
}

TEST(BodyBinding, BindsAnewWhatIsSeenBesideOtherBones) {
  const PosedBody straight = somebody(0);
  const PosedBody bent = somebody(1.5);
  const std::vector<SE3> nodes = three_nodes(bent); // the body was taken to hold its arm straight
  const std::vector<SE3> nodes_before = {straight.bones[kHead] * SE3(Eigen::Translation3d(0, 0.1, 0.1)), nodes[1],
                                         nodes[2]};
  for (const double seen : {0.0, 1.0}) {
    BodyBinding binding;
    binding.bind(straight, nodes_before, kUnseen);
    EXPECT_FALSE(binding.limb_of(0));
    binding.bind(bent, nodes, std::vector<double>(3, seen));
    EXPECT_EQ(binding.limb_of(0).has_value(), seen > 0);
    EXPECT_FALSE(binding.limb_of(1));
    if (seen == 0) continue;
    EXPECT_LT((*binding.place_of(0, bent.bones) - nodes[0].translation()).norm(), 1e-9);
    EXPECT_LT((*binding.place_of(0, straight.bones) - three_places(straight)[0]).norm(), 1e-9);
  }
}

TEST(BodyBinding, KeepsTheBonesThatANodeIsHardlyFartherFrom) {
  const PosedBody body = somebody(0);
  std::vector<SE3> nodes = three_nodes(body);
  BodyBinding binding;
  binding.bind(body, nodes, kUnseen);
  nodes[0] = body.bones[kLeftElbow] * SE3(Eigen::Translation3d(-0.03, 0, 0.04)); // on the upper arm
  binding.bind(body, nodes, std::vector<double>(3, 1));
  EXPECT_LT((*binding.place_of(0, body.bones) - three_places(body)[0]).norm(), 1e-9);
}

TEST(BodyBinding, AnArmDoesNotHangOnWhatItLiesOn) {
  const PosedBody body = somebody(0);
  const auto on = [&](Joint bone, double x, double y, double z) {
    return SE3(body.bones[bone] * Eigen::Translation3d(x, y, z));
  };
  enum { kUpperArm, kForearm, kOtherForearm, kTrunk, kThigh, kOtherThigh, kNothing };
  const std::vector<SE3> nodes = {on(kLeftShoulder, 0.12, 0, 0.05),
                                  on(kLeftElbow, 0.13, 0, 0.04),
                                  on(kRightElbow, -0.13, 0, 0.04),
                                  on(kSpine, 0, 0.05, 0.12),
                                  on(kLeftHip, 0, -0.2, 0.08),
                                  on(kRightHip, 0, -0.2, 0.08),
                                  on(kHead, 0, 0.6, 0)};
  BodyBinding binding;
  binding.bind(body, nodes, kUnseen);
  for (const auto& [a, b] : {std::pair(kForearm, kTrunk), std::pair(kForearm, kThigh), std::pair(kUpperArm, kThigh),
                             std::pair(kForearm, kOtherForearm)}) {
    EXPECT_TRUE(binding.are_apart(a, b) && binding.are_apart(b, a)) << a << ", " << b;
  }
  for (const auto& [a, b] : {std::pair(kForearm, kUpperArm), std::pair(kUpperArm, kTrunk), std::pair(kTrunk, kThigh),
                             std::pair(kThigh, kOtherThigh), std::pair(kForearm, kNothing)}) {
    EXPECT_FALSE(binding.are_apart(a, b) || binding.are_apart(b, a)) << a << ", " << b;
  }
}

TEST(BodyBinding, TurnsNodesAsBeforeWhenTheirCanonicalTurnIsAnother) {
  const PosedBody straight = somebody(0);
  const PosedBody bent = somebody(1);
  BodyBinding binding;
  binding.bind(straight, three_nodes(straight), kUnseen);
  const std::vector<SE3> before = binding.placed(bent.bones);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Vec(1, 2, -1).normalized()));
  const std::vector<Eigen::Quaterniond> turns(3, turn);
  binding.turn_back(turns);
  const std::vector<SE3> after = binding.placed(bent.bones);
  for (std::size_t n = 0; n < 3; ++n) {
    EXPECT_LT((after[n].translation() - before[n].translation()).norm(), 1e-12) << n;
    EXPECT_LT((after[n].linear() * turn.toRotationMatrix() - before[n].linear()).norm(), 1e-12) << n;
  }
}

TEST(BodyBinding, GoesByWhatIsSeenAndKeepsWhatIsNot) {
  const PosedBody body = somebody(0);
  const Vec slipped(0, 0.03, 0);
  std::vector<SE3> nodes = three_nodes(body);
  BodyBinding binding;
  binding.bind(body, nodes, kUnseen);
  for (SE3& node : nodes) node.translation() += slipped;
  for (int frame = 0; frame < 60; ++frame) binding.renew(body.bones, nodes, std::vector<double>{1, 0, 0});
  EXPECT_LT((*binding.place_of(0, body.bones) - nodes[0].translation()).norm(), 1e-3);
  EXPECT_LT((*binding.place_of(1, body.bones) - (nodes[1].translation() - slipped)).norm(), 1e-9);
}

TEST(BodyBinding, ALostLimbPullsNothing) {
  const PosedBody body = somebody(0);
  BodyBinding binding;
  binding.bind(body, three_nodes(body), kUnseen);
  SE3 from_world = SE3::Identity();
  from_world.translation() = Vec(1, 2, 3);
  const auto pulls = binding.pulls(body.bones, kAllSeen, from_world, 0.02);
  ASSERT_EQ(pulls.size(), 3U);
  EXPECT_LT((pulls[0].place - from_world * three_places(body)[0]).norm(), 1e-9);
  EXPECT_DOUBLE_EQ(pulls[0].scale, 50);
  EXPECT_EQ(pulls[2].scale, 0);
  std::array<LimbHealth, kLimbs> limbs = kAllSeen;
  limbs[kLeftArm] = LimbHealth::kLost;
  const auto without = binding.pulls(body.bones, limbs, from_world, 0.02);
  EXPECT_EQ(without[0].scale, 0);
  EXPECT_DOUBLE_EQ(without[1].scale, 50);
}

} // namespace
} // namespace kinora::tracking
