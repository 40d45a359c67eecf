#include "tracking/body/limbs.h"

#include <gtest/gtest.h>

#include "tracking/body/synthetic_body.h"

namespace kinora::tracking {
namespace {

// Wrist or ankle after the limb was sent to a place `away` from its ball joint, in the pelvis' axes.
void expect_reached(Limb limb, const Eigen::Vector3d& away, double swivel) {
  BodyState state = testing::standing(30);
  const PosedBody body = pose_body(state.pose, state.shape);
  const LimbChain& chain = chain_of(limb);
  const Eigen::Vector3d target = body.bones[chain.ball].translation() + state.pose.root.linear() * away;
  state.pose.angles = inverse_kinematics(limb, state.pose.angles, body, target, swivel, 0);
  const Bones bones = forward_kinematics(state.pose, state.shape);
  // Shanks are not quite in line with straight knees, which is left out there.
  const double bound = limb == kLeftArm || limb == kRightArm ? 1e-6 : 0.03;
  EXPECT_LT((bones[chain.end].translation() - target).norm(), bound) << limb << ", swivel " << swivel;
  EXPECT_GE(state.pose.angles[joints()[chain.hinge].first_angle], 0);
}

TEST(Limbs, ReachWhateverIsNearEnoughWithAnySwivel) {
  for (const double swivel : {0.0, 1.0, 2.5, 4.0}) {
    for (const Limb limb : {kLeftArm, kRightArm, kLeftLeg, kRightLeg}) {
      expect_reached(limb, {0.1, -0.3, 0.25}, swivel);
      expect_reached(limb, {-0.2, -0.2, 0.1}, swivel);
    }
  }
}

TEST(Limbs, PointAtWhatIsTooFar) {
  BodyState state = testing::standing(0);
  const PosedBody body = pose_body(state.pose, state.shape);
  const Eigen::Vector3d shoulder = body.bones[kLeftShoulder].translation();
  const Eigen::Vector3d way(0.6, -0.8, 0);
  state.pose.angles = inverse_kinematics(kLeftArm, state.pose.angles, body, shoulder + 5 * way, 0, 0);
  const Bones bones = forward_kinematics(state.pose, state.shape);
  EXPECT_GT((bones[kLeftWrist].translation() - shoulder).normalized().dot(way), 0.9999);
}

TEST(Limbs, OwnTheirBonesAndNoOthers) {
  EXPECT_EQ(limb_of(kLeftElbow), kLeftArm);
  EXPECT_EQ(limb_of(kRightAnkle), kRightLeg);
  EXPECT_EQ(limb_of(kHead), std::nullopt);
  EXPECT_EQ(limb_of(kLeftClavicle), std::nullopt);
}

} // namespace
} // namespace kinora::tracking
