#include "tracking/body/bone_attachment.h"

#include <gtest/gtest.h>

#include "tracking/body/synthetic_body.h"

namespace kinora::tracking {
namespace {

PosedBody somebody() {
  const BodyState state = testing::standing(0);
  return pose_body(state.pose, state.shape);
}

TEST(BoneAttachment, GivesAPointToTheBoneThatItLiesOn) {
  const PosedBody body = somebody();
  const auto middle = attach_to_bones(body, body.bones[kLeftElbow] * Eigen::Vector3d(0.13, 0, 0.04));
  ASSERT_TRUE(middle);
  EXPECT_EQ(middle->bone, kLeftElbow);
  EXPECT_EQ(middle->weight, 1);
  const auto joint = attach_to_bones(body, body.bones[kLeftElbow] * Eigen::Vector3d(0.005, 0, 0.045));
  ASSERT_TRUE(joint);
  EXPECT_TRUE(joint->bone == kLeftElbow || joint->bone == kLeftShoulder);
  EXPECT_NE(joint->second, joint->bone);
  EXPECT_LT(joint->weight, 0.8);
}

TEST(BoneAttachment, KnowsHowFarABonesSurfaceIs) {
  const PosedBody body = somebody();
  const Eigen::Vector3d inside = body.bones[kLeftElbow] * Eigen::Vector3d(0.13, 0, 0);
  const Eigen::Vector3d beside = body.bones[kLeftElbow] * Eigen::Vector3d(0.13, 0, 0.14);
  EXPECT_LT(distance_to_bone(body, kLeftElbow, inside), -0.02);
  EXPECT_NEAR(distance_to_bone(body, kLeftElbow, beside), 0.1, 0.03);
  EXPECT_GT(distance_to_bone(body, kRightElbow, beside), 0.3);
}

TEST(BoneAttachment, GivesWhatIsFarFromTheBodyToNoBone) {
  const PosedBody body = somebody();
  EXPECT_FALSE(attach_to_bones(body, body.bones[kHead] * Eigen::Vector3d(0, 0.5, 0)));
}

} // namespace
} // namespace kinora::tracking
