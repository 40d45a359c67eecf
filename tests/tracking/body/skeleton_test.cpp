#include "tracking/body/skeleton.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace kinora::tracking {
namespace {

struct Body {
  BodyPose pose;
  Shape shape;
};

Body random_body(std::uint64_t seed) {
  Random random(seed);
  Body body;
  PoseStep step;
  for (double& value : step) value = random.normal();
  for (double& measure : body.shape) measure = 0.2 * random.normal();
  body.pose = moved(BodyPose(), step);
  return body;
}

Body varied(const Body& body, int dof, double amount) {
  Body result = body;
  PoseStep step = PoseStep::Zero();
  if (dof < kPoseDof) {
    step[dof] = amount;
    result.pose = moved(body.pose, step);
  } else {
    result.shape[dof - kPoseDof] += amount;
  }
  return result;
}

TEST(Skeleton, TwistsAreTheDerivativesOfPointsOnBones) {
  const Body body = random_body(1);
  const Bones bones = forward_kinematics(body.pose, body.shape);
  BoneTwists twists;
  find_bone_twists(body.pose, body.shape, bones, twists);
  const Eigen::Vector3d local(0.05, -0.1, 0.2);
  constexpr double kStep = 1e-6;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const Eigen::Vector3d point = bones[j] * local;
    for (int f = 0; f < kDof; ++f) {
      const Body more = varied(body, f, kStep);
      const Body less = varied(body, f, -kStep);
      const Eigen::Vector3d numeric = (forward_kinematics(more.pose, more.shape)[j] * local -
                                       forward_kinematics(less.pose, less.shape)[j] * local) /
                                      (2 * kStep);
      const Twist twist = twists[j].col(f);
      const Eigen::Vector3d analytic = twist.head<3>() + twist.tail<3>().cross(point);
      EXPECT_LT((numeric - analytic).norm(), 1e-7) << joints()[j].name << ", freedom " << f;
    }
  }
}

TEST(Skeleton, TheStepBetweenTwoPosesLeadsFromOneToTheOther) {
  const Body a = random_body(2);
  const Body b = random_body(3);
  const BodyPose reached = moved(a.pose, step_between(a.pose, b.pose));
  EXPECT_LT((reached.root.matrix() - b.pose.root.matrix()).norm(), 1e-12);
  EXPECT_LT((reached.angles - b.pose.angles).norm(), 1e-12);
}

TEST(Skeleton, BothSidesAreMirrorImagesInTheUsualPose) {
  const Bones bones = forward_kinematics(rest_pose(), Shape::Zero());
  constexpr std::array<std::pair<Joint, Joint>, 7> kPairs = {{{kLeftClavicle, kRightClavicle},
                                                              {kLeftShoulder, kRightShoulder},
                                                              {kLeftElbow, kRightElbow},
                                                              {kLeftWrist, kRightWrist},
                                                              {kLeftHip, kRightHip},
                                                              {kLeftKnee, kRightKnee},
                                                              {kLeftAnkle, kRightAnkle}}};
  for (const auto& [left, right] : kPairs) {
    const Eigen::Vector3d mirrored = bones[right].translation().cwiseProduct(Eigen::Vector3d(-1, 1, 1));
    EXPECT_LT((bones[left].translation() - mirrored).norm(), 1e-12) << joints()[left].name;
  }
}

TEST(Skeleton, ArmsHangBesideTheBodyAndBendForwardsInTheUsualPose) {
  const Bones bones = forward_kinematics(rest_pose(), Shape::Zero());
  EXPECT_LT(bones[kLeftElbow].translation().y(), bones[kLeftShoulder].translation().y() - 0.2);
  EXPECT_GT(bones[kLeftWrist].translation().z(), bones[kLeftElbow].translation().z() + 0.05);
  EXPECT_LT(bones[kLeftAnkle].translation().z(), bones[kLeftKnee].translation().z());
}

TEST(Skeleton, KeepsItsPrecisionAKilometreAway) {
  const Body near = random_body(4);
  Body far = near;
  const Eigen::Vector3d offset(1000, -1000, 1000);
  far.pose.root.translation() += offset;
  const Bones a = forward_kinematics(near.pose, near.shape);
  const Bones b = forward_kinematics(far.pose, far.shape);
  for (std::size_t j = 0; j < kJoints; ++j) {
    EXPECT_LT((b[j].translation() - offset - a[j].translation()).norm(), 1e-11);
  }
}

} // namespace
} // namespace kinora::tracking
