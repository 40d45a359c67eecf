#include "tracking/deforming/bone_skinning.h"

#include <utility>

#include <gtest/gtest.h>

#include "tracking/body/synthetic_body.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

constexpr std::array<LimbHealth, kLimbs> kAllSeen = {LimbHealth::kSeen, LimbHealth::kSeen, LimbHealth::kSeen,
                                                     LimbHealth::kSeen};

PosedBody somebody(double elbow_angle) {
  BodyState state = testing::standing(0);
  state.pose.angles[joints()[kLeftElbow].first_angle] += elbow_angle;
  return pose_body(state.pose, state.shape);
}

const std::vector<double> kUnseen(4, 0);

/// A node on the left forearm, one on the head, one beside nobody.
std::vector<SE3> three_nodes(const PosedBody& body) {
  const auto at = [](double x, double y, double z) { return SE3(Eigen::Translation3d(x, y, z)); };
  return {body.bones[kLeftElbow] * at(0.13, 0, 0.04), body.bones[kHead] * at(0, 0.1, 0.1),
          body.bones[kHead] * at(0, 0.6, 0)};
}

std::vector<Vec> three_positions(const PosedBody& body) {
  std::vector<Vec> positions;
  for (const SE3& node : three_nodes(body)) positions.emplace_back(node.translation());
  return positions;
}

TEST(BoneSkinning, CarriesANodeWithItsBone) {
  const PosedBody straight = somebody(0);
  const PosedBody bent = somebody(1);
  BoneSkinning binding;
  binding.bind(straight, three_nodes(straight), kUnseen);
  EXPECT_GT((three_positions(bent)[0] - three_positions(straight)[0]).norm(), 0.05);
  for (const std::size_t n : {0U, 1U}) {
    const auto position = binding.position_of(n, bent.bones);
    ASSERT_TRUE(position);
    EXPECT_LT((*position - three_positions(bent)[n]).norm(), 1e-9) << n;
  }
  EXPECT_FALSE(binding.position_of(2, bent.bones));
}

TEST(BoneSkinning, BindsOnlyNodesThatAreNew) {
  const PosedBody straight = somebody(0);
  const PosedBody bent = somebody(1);
  BoneSkinning binding;
  std::vector<SE3> nodes = three_nodes(straight);
  binding.bind(straight, nodes, kUnseen);
  nodes.push_back(three_nodes(bent)[0]);
  binding.bind(bent, nodes, kUnseen);
  EXPECT_LT((*binding.position_of(0, straight.bones) - nodes[0].translation()).norm(), 1e-9);
  EXPECT_LT((*binding.position_of(3, straight.bones) - nodes[0].translation()).norm(), 1e-9);
}

TEST(BoneSkinning, BindsAnewWhatIsSeenBesideOtherBones) {
  const PosedBody straight = somebody(0);
  const PosedBody bent = somebody(1.5);
  const std::vector<SE3> nodes = three_nodes(bent); // the body was taken to hold its arm straight
  const std::vector<SE3> nodes_before = {straight.bones[kHead] * SE3(Eigen::Translation3d(0, 0.1, 0.1)), nodes[1],
                                         nodes[2]};
  for (const double seen : {0.0, 1.0}) {
    BoneSkinning binding;
    binding.bind(straight, nodes_before, kUnseen);
    EXPECT_FALSE(binding.limb_of(0));
    binding.bind(bent, nodes, std::vector<double>(3, seen));
    EXPECT_EQ(binding.limb_of(0).has_value(), seen > 0);
    EXPECT_FALSE(binding.limb_of(1));
    if (seen == 0) continue;
    EXPECT_LT((*binding.position_of(0, bent.bones) - nodes[0].translation()).norm(), 1e-9);
    EXPECT_LT((*binding.position_of(0, straight.bones) - three_positions(straight)[0]).norm(), 1e-9);
  }
}

TEST(BoneSkinning, KeepsTheBonesThatANodeIsHardlyFartherFrom) {
  const PosedBody body = somebody(0);
  std::vector<SE3> nodes = three_nodes(body);
  BoneSkinning binding;
  binding.bind(body, nodes, kUnseen);
  nodes[0] = body.bones[kLeftElbow] * SE3(Eigen::Translation3d(-0.03, 0, 0.04)); // on the upper arm
  binding.bind(body, nodes, std::vector<double>(3, 1));
  EXPECT_LT((*binding.position_of(0, body.bones) - three_positions(body)[0]).norm(), 1e-9);
}

TEST(BoneSkinning, AnArmDoesNotHangOnWhatItLiesOn) {
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
  BoneSkinning binding;
  binding.bind(body, nodes, kUnseen);
  for (const auto& [a, b] : {std::pair(kForearm, kTrunk), std::pair(kForearm, kThigh), std::pair(kUpperArm, kThigh),
                             std::pair(kForearm, kOtherForearm)}) {
    EXPECT_TRUE(binding.are_disconnected(a, b) && binding.are_disconnected(b, a)) << a << ", " << b;
  }
  for (const auto& [a, b] : {std::pair(kForearm, kUpperArm), std::pair(kUpperArm, kTrunk), std::pair(kTrunk, kThigh),
                             std::pair(kThigh, kOtherThigh), std::pair(kForearm, kNothing)}) {
    EXPECT_FALSE(binding.are_disconnected(a, b) || binding.are_disconnected(b, a)) << a << ", " << b;
  }
}

TEST(BoneSkinning, TurnsNodesAsBeforeWhenTheirCanonicalTurnIsAnother) {
  const PosedBody straight = somebody(0);
  const PosedBody bent = somebody(1);
  BoneSkinning binding;
  binding.bind(straight, three_nodes(straight), kUnseen);
  const std::vector<SE3> before = binding.node_transforms(bent.bones);
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(0.7, Vec(1, 2, -1).normalized()));
  const std::vector<Eigen::Quaterniond> rotations(3, rotation);
  binding.apply_inverse_rotation(rotations);
  const std::vector<SE3> after = binding.node_transforms(bent.bones);
  for (std::size_t n = 0; n < 3; ++n) {
    EXPECT_LT((after[n].translation() - before[n].translation()).norm(), 1e-12) << n;
    EXPECT_LT((after[n].linear() * rotation.toRotationMatrix() - before[n].linear()).norm(), 1e-12) << n;
  }
}

TEST(BoneSkinning, GoesByWhatIsSeenAndKeepsWhatIsNot) {
  const PosedBody body = somebody(0);
  const Vec slipped(0, 0.03, 0);
  std::vector<SE3> nodes = three_nodes(body);
  BoneSkinning binding;
  binding.bind(body, nodes, kUnseen);
  for (SE3& node : nodes) node.translation() += slipped;
  for (int frame = 0; frame < 60; ++frame) binding.update_offsets(body.bones, nodes, std::vector<double>{1, 0, 0});
  EXPECT_LT((*binding.position_of(0, body.bones) - nodes[0].translation()).norm(), 1e-3);
  EXPECT_LT((*binding.position_of(1, body.bones) - (nodes[1].translation() - slipped)).norm(), 1e-9);
}

TEST(BoneSkinning, ALostLimbPullsNothing) {
  const PosedBody body = somebody(0);
  BoneSkinning binding;
  binding.bind(body, three_nodes(body), kUnseen);
  SE3 from_world = SE3::Identity();
  from_world.translation() = Vec(1, 2, 3);
  const auto targets = binding.targets(body.bones, kAllSeen, from_world, 0.02);
  ASSERT_EQ(targets.size(), 3U);
  EXPECT_LT((targets[0].position - from_world * three_positions(body)[0]).norm(), 1e-9);
  EXPECT_DOUBLE_EQ(targets[0].scale, 50);
  EXPECT_EQ(targets[2].scale, 0);
  std::array<LimbHealth, kLimbs> limbs = kAllSeen;
  limbs[kLeftArm] = LimbHealth::kLost;
  const auto without = binding.targets(body.bones, limbs, from_world, 0.02);
  EXPECT_EQ(without[0].scale, 0);
  EXPECT_DOUBLE_EQ(without[1].scale, 50);
}

} // namespace
} // namespace kinora::tracking
