#include "tracking/body/hand_contact.h"

#include <gtest/gtest.h>

#include "tracking/body/body_tracker.h"
#include "tracking/body/synthetic_body.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;
using testing::BodyScene;
using testing::joint_distance;
using testing::render_body;
using testing::standing;

// What a held hand adds to the gradient, which is half that of the energy, against differences of the energy.
TEST(HandContact, GradientAgreesWithDifferences) {
  const BodyState state = standing(20);
  const LayerView view = view_label(render_body(state), 1);
  BodyEvidence evidence = gather_evidence(view, 100, {});
  evidence.points.clear();
  BodyPrior alone;
  alone.state = state;
  for (const double away : {0.01, 0.05}) {
    BodyPrior holding = alone;
    holding.hands = {{kRightArm, heel_of_hand(pose_body(state.pose, state.shape), kRightArm) + Vec(away, -away, 0.01)}};
    const Eigen::Matrix<double, kDof, 1> gradient =
        evaluate(evidence, state, holding, {}).gradient - evaluate(evidence, state, alone, {}).gradient;
    const auto energy = [&](int dof, double step) {
      PoseStep pose_step = PoseStep::Zero();
      BodyState moved_state = state;
      if (dof < kPoseDof) {
        pose_step[dof] = step;
      } else {
        moved_state.shape[dof - kPoseDof] += step;
      }
      moved_state.pose = moved(state.pose, pose_step);
      return contact_energy(holding.hands[0], pose_body(moved_state.pose, moved_state.shape), {});
    };
    EXPECT_GT(gradient.norm(), 1);
    for (int f = 0; f < kDof; ++f) {
      constexpr double kStep = 1e-6;
      const double expected = (energy(f, kStep) - energy(f, -kStep)) / (4 * kStep);
      EXPECT_NEAR(gradient[f], expected, 1e-4 * (1 + gradient.norm())) << away << ' ' << f;
    }
  }
}

// Stretches the left forearm out to the side and bends it upwards, behind something from the eighth frame on.
BodyState bending(int frame) {
  BodyState state = standing(0);
  state.pose.angles.segment<3>(joints()[kLeftShoulder].first_angle) = Vec(0, -0.2, -0.6);
  state.pose.angles[joints()[kLeftElbow].first_angle] = 0.3 + 0.05 * frame;
  return state;
}

/// A thing of one point in the left hand of `state`.
NearbyObject thing_in_hand(const BodyState& state) {
  static const std::vector<SurfacePoint> surface = {{{0.08F, -0.05F, 0}, Eigen::Vector3f::UnitY(), 0, 1}};
  return {2, forward_kinematics(state.pose, state.shape)[kLeftWrist], surface, Vec::Zero()};
}

// Mean error of the left wrist in the last frames, metres.
double wrist_error(bool with_thing) {
  BodyTracker tracker;
  double sum = 0;
  for (int i = 0; i < 24; ++i) {
    BodyScene scene;
    scene.seed = static_cast<std::uint64_t>(i);
    if (i >= 8) scene.cover = testing::Cover{152, 20, 210, 130};
    const NearbyObject thing = thing_in_hand(bending(i));
    tracker.track(view_label(render_body(bending(i), scene), 1), SE3::Identity(), i / 30.0,
                  std::span(&thing, with_thing ? 1 : 0));
    if (i >= 16) sum += joint_distance(tracker.state(), bending(i), kLeftWrist) / 8;
  }
  return sum;
}

TEST(HandContact, AHiddenWristGoesWithTheThingInTheHand) {
  const double without = wrist_error(false);
  EXPECT_GT(without, 0.08);
  EXPECT_LT(wrist_error(true), 0.04) << without;
}

// The hand lets go in the third frame and is seen all the time; the thing stays.
TEST(HandContact, AHandThatLetsGoLeavesTheThing) {
  BodyTracker tracker;
  for (int i = 0; i < 20; ++i) {
    BodyScene scene;
    scene.seed = static_cast<std::uint64_t>(i);
    const NearbyObject thing = thing_in_hand(bending(std::min(i, 3)));
    tracker.track(view_label(render_body(bending(i), scene), 1), SE3::Identity(), i / 30.0, {&thing, 1});
  }
  EXPECT_LT(joint_distance(tracker.state(), bending(19), kLeftWrist), 0.03);
}

} // namespace
} // namespace kinora::tracking
