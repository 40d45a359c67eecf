#include "tracking/body/body_fit.h"

#include <gtest/gtest.h>

#include "tracking/body/body_pose_database.h"
#include "tracking/body/synthetic_body.h"

namespace kinora::tracking {
namespace {

BodyState fitted(const BodyState& truth, const testing::BodyScene& scene = {}) {
  const LayerView view = view_label(testing::render_body(truth, scene), 1);
  return fit_body(view, {}, {}).state;
}

class FitOfTurnedBody : public ::testing::TestWithParam<int> {};

TEST_P(FitOfTurnedBody, FindsSizeSideAndJoints) {
  for (const double height : {1.5, 1.9}) {
    const BodyState truth = testing::standing(GetParam(), height);
    const BodyState found = fitted(truth);
    EXPECT_LT(testing::mean_joint_distance(found, truth), 0.04) << height;
    EXPECT_NEAR(std::exp(found.shape[kHeight]) * kMeanHeight, height, 0.02 * height);
  }
}
INSTANTIATE_TEST_SUITE_P(Sides, FitOfTurnedBody, ::testing::Values(0, 45, 100, 180, 250, 320));

TEST(BodyFit, FindsArmsInOtherPosesThanUsual) {
  BodyState truth = testing::standing(20);
  const auto set = [&truth](Joint joint, const Eigen::Vector3d& angles) {
    truth.pose.angles.segment(joints()[joint].first_angle, joints()[joint].angle_count) =
        angles.head(joints()[joint].angle_count);
  };
  set(kLeftShoulder, {0, -0.5, 0.5}); // raised
  set(kLeftElbow, {1.2, 0, 0});
  set(kRightShoulder, {0, 1.2, 0.5}); // stretched forwards and down
  set(kRightElbow, {0.3, 0, 0});
  const BodyState found = fitted(truth);
  for (const Joint joint : {kLeftElbow, kRightElbow, kLeftWrist, kRightWrist}) {
    EXPECT_LT(testing::joint_distance(found, truth, joint), 0.03) << joints()[joint].name;
  }
}

// Whose arms are stretched to the sides looks alike from both sides until the limbs are searched for.
TEST(BodyFit, TellsAFrontFromABackWithArmsStretched) {
  for (const int degrees : {0, 180}) {
    BodyState truth = testing::standing(degrees, 1.75);
    truth.pose.angles.setZero();
    truth.pose.angles.segment<3>(joints()[kLeftShoulder].first_angle) = Eigen::Vector3d(-0.52, 0.04, -0.14);
    truth.pose.angles.segment<3>(joints()[kRightShoulder].first_angle) = Eigen::Vector3d(-0.52, -0.04, 0.14);
    EXPECT_LT(testing::mean_joint_distance(fitted(truth), truth), 0.03) << degrees;
  }
}

// Who raises an arm, seen from the side, is taken for somebody of another side unless the pose is known.
TEST(BodyFit, FindsAPoseThatItHadEarlierElsewhere) {
  BodyState truth = testing::standing(235, 1.75);
  truth.pose.angles.segment<3>(joints()[kLeftShoulder].first_angle) = Eigen::Vector3d(0, -0.5, 0.5);
  EXPECT_GT(testing::mean_joint_distance(fitted(truth), truth), 0.1);
  BodyPoseDatabase earlier;
  for (const int degrees : {200, 225, 240, 270}) {
    BodyState other = truth;
    other.pose.root = testing::standing(degrees).pose.root;
    const LayerView view = view_label(testing::render_body(other), 1);
    earlier.add(other.pose, forward_kinematics(other.pose, other.shape), view.centroid);
  }
  truth.pose.root.translation() += Eigen::Vector3d(0.3, 0, 0.3);
  const LayerView view = view_label(testing::render_body(truth), 1);
  const BodyFit fit = fit_body(view, {}, {}, earlier.about(view.centroid));
  EXPECT_LT(testing::mean_joint_distance(fit.state, truth), 0.03);
}

TEST(BodyFit, FindsSomebodyWhoseLegsAreOutOfThePicture) {
  BodyState truth = testing::standing(-15);
  truth.pose.root.translation() += Eigen::Vector3d(0, 0.45, -1.0);
  const BodyState found = fitted(truth);
  for (const Joint joint : {kNeck, kLeftShoulder, kRightShoulder}) {
    EXPECT_LT(testing::joint_distance(found, truth, joint), 0.08) << joints()[joint].name;
  }
}

} // namespace
} // namespace kinora::tracking
