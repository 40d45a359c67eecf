#include "tracking/body/body_motion.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "tracking/body/synthetic_body.h"

namespace kinora::tracking {
namespace {

BodyState raised_arm() {
  BodyState state = testing::standing(0);
  state.pose.angles[joints()[kLeftElbow].first_angle] += 1.0;
  return state;
}

BodyMotion two_frames() {
  const BodyState first = testing::standing(0);
  return {first.shape, {std::nullopt, BodyFrame{first.pose}, BodyFrame{raised_arm().pose}}};
}

TEST(BodyMotion, CarriesAPointOfABoneAlongWithIt) {
  const BodyMotion motion = two_frames();
  const BodyState first = testing::standing(0);
  const BodyState second = raised_arm();
  const Eigen::Vector3d local(0.1, 0.02, 0);
  const Eigen::Vector3d canonical = place_bones(first.pose, first.shape)[kLeftElbow] * local;
  const Eigen::Vector3d now = place_bones(second.pose, second.shape)[kLeftElbow] * local;
  EXPECT_GT((now - canonical).norm(), 0.05);
  EXPECT_LT((motion.canonical_to_world(2, kLeftElbow) * canonical - now).norm(), 1e-12);
}

TEST(BodyMotion, IsTheIdentityUpToTheFirstFrameOfThePerson) {
  const BodyMotion motion = two_frames();
  EXPECT_FALSE(motion.bones(0));
  for (const std::size_t frame : {0U, 1U}) {
    EXPECT_LT((motion.canonical_to_world(frame, kHead).matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-12);
  }
}

TEST(BodyMotion, GivesAPointToTheBoneThatItLiesOn) {
  const BodyMotion motion = two_frames();
  const Bones bones = *motion.bones(1);
  const auto middle = motion.hold_of(bones[kLeftElbow] * Eigen::Vector3d(0.13, 0, 0.04));
  ASSERT_TRUE(middle);
  EXPECT_EQ(middle->bone, kLeftElbow);
  EXPECT_EQ(middle->weight, 1);
  const auto joint = motion.hold_of(bones[kLeftElbow] * Eigen::Vector3d(0.005, 0, 0.045));
  ASSERT_TRUE(joint);
  EXPECT_TRUE(joint->bone == kLeftElbow || joint->bone == kLeftShoulder);
  EXPECT_NE(joint->second, joint->bone);
  EXPECT_LT(joint->weight, 0.8);
}

TEST(BodyMotion, GivesWhatIsFarFromTheBodyToNoBone) {
  const BodyMotion motion = two_frames();
  const Bones bones = *motion.bones(1);
  EXPECT_FALSE(motion.hold_of(bones[kHead] * Eigen::Vector3d(0, 0.5, 0)));
}

TEST(BodyMotion, NeedsAFrameWithThePerson) { EXPECT_THROW(BodyMotion(Shape::Zero(), {std::nullopt}), Error); }

} // namespace
} // namespace kinora::tracking
