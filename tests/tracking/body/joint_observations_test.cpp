#include "tracking/body/joint_observations.h"

#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "tracking/body/body_fit.h"
#include "tracking/body/body_tracker.h"
#include "tracking/body/simulated_detector.h"
#include "tracking/body/synthetic_body.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;
using testing::BodyScene;
using testing::DetectorErrors;
using testing::joint_distance;
using testing::mean_joint_distance;
using testing::render_body;
using testing::standing;

// As the detector would see them; `errors`: none: nobody looks.
LayerView view_of(const BodyState& state, const BodyScene& scene, const std::optional<DetectorErrors>& errors) {
  ingest::Frame frame = render_body(state, scene);
  if (errors) {
    testing::JointPositions positions;
    const PosedBody body = pose_body(state.pose, state.shape);
    for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = position_of(landmark_of(i), body);
    const auto joints =
        testing::detect_joints(positions, frame.camera.intrinsics, frame.depth, *errors, scene.seed + 1000);
    frame.people = {{1, joints}};
  }
  return view_label(frame, 1);
}

DetectorErrors perfect() { return {0, 0, 0, 0, true}; }

// Half of the energy's slope by every freedom of pose and measures.
TEST(DetectedJoints, GradientAgreesWithDifferences) {
  const BodyState seen = standing(20);
  BodyState state = seen;
  state.pose.root.translation() += Vec(0.03, -0.02, 0.05);
  state.pose.angles.array() += 0.05;
  state.shape.setConstant(0.04);
  const LayerView view = view_of(seen, {}, perfect());
  BodyEvidence with = gather_evidence(view, 100, {});
  ASSERT_EQ(with.joints.size(), ingest::kDetectedJoints);
  with.points.clear();
  BodyEvidence without = with;
  without.joints.clear();
  BodyPrior prior;
  prior.state = state;
  const Eigen::Matrix<double, kDof, 1> gradient =
      evaluate(with, state, prior, {}).gradient - evaluate(without, state, prior, {}).gradient;
  EXPECT_GT(gradient.norm(), 1);
  const auto energy = [&](int dof, double step) {
    PoseStep pose_step = PoseStep::Zero();
    BodyState moved_state = state;
    if (dof < kPoseDof) {
      pose_step[dof] = step;
    } else {
      moved_state.shape[dof - kPoseDof] += step;
    }
    moved_state.pose = moved(state.pose, pose_step);
    return energy_of(with.joints, pose_body(moved_state.pose, moved_state.shape), DetectedJointsConfig());
  };
  for (int f = 0; f < kDof; ++f) {
    constexpr double kStep = 1e-6;
    const double expected = (energy(f, kStep) - energy(f, -kStep)) / (4 * kStep);
    EXPECT_NEAR(gradient[f], expected, 1e-4 * (1 + gradient.norm())) << f;
  }
}

TEST(DetectedJoints, JointsOfLowScoreOrNoPlaceAreLeftOut) {
  ingest::DetectedJoints joints;
  joints[3] = {{10, 10}, 0.9};
  joints[4] = {{10, 10}, 0.1};
  joints[5] = {{std::nan(""), 10}, 0.9};
  joints[6] = {{10, 10}, std::nan("")};
  const Intrinsics camera{100, 100, 80, 80, 50, 50};
  const auto observed = observe_joints(joints, camera, {});
  ASSERT_EQ(observed.size(), 1U);
  EXPECT_EQ(observed[0].joint, 3U);
  EXPECT_NEAR(observed[0].ray.x(), -0.5, 1e-12);
}

// Stretches the left forearm out to the side and bends it upwards.
BodyState bending(int frame) {
  BodyState state = standing(0);
  state.pose.angles.segment<3>(joints()[kLeftShoulder].first_angle) = Vec(0, -0.2, -0.6);
  state.pose.angles[joints()[kLeftElbow].first_angle] = 0.3 + 0.05 * frame;
  return state;
}

// Five pixels of 640×480 are two of these pictures.
DetectorErrors usual_errors() { return {2, 0.1, 0.1, 0, true}; }

// Mean error of the left wrist in the last frames, metres. From the eighth frame on there is no depth on that side of
// the picture, as of a black sleeve; or something stands before it.
double wrist_error(const std::optional<DetectorErrors>& errors, bool is_covered) {
  BodyTracker tracker;
  double sum = 0;
  for (int i = 0; i < 24; ++i) {
    BodyScene scene;
    scene.seed = static_cast<std::uint64_t>(i);
    const testing::Cover side{152, 20, 210, 130};
    if (i >= 8) (is_covered ? scene.cover : scene.hole) = side;
    tracker.track(view_of(bending(i), scene, errors), SE3::Identity(), i / 30.0);
    if (i >= 16) sum += joint_distance(tracker.state(), bending(i), kLeftWrist) / 8;
  }
  return sum;
}

DetectorErrors with_swaps() {
  DetectorErrors errors = usual_errors();
  errors.swaps = 0.2;
  return errors;
}

TEST(DetectedJoints, DoNotHarmAWristWithoutDepth) {
  EXPECT_LT(wrist_error(with_swaps(), false), wrist_error(std::nullopt, false) + 0.005);
}

TEST(DetectedJoints, HelpAWristThatSomethingHides) {
  const double without = wrist_error(std::nullopt, true);
  EXPECT_GT(without, 0.15);
  EXPECT_LT(wrist_error(perfect(), true), 0.08);
  EXPECT_LT(wrist_error(usual_errors(), true), 0.95 * without);
  EXPECT_LT(wrist_error(with_swaps(), true), without);
}

// Turns by 12° a frame with an arm that hits out, and is seen all the time.
double seen_error(const std::optional<DetectorErrors>& errors) {
  BodyTracker tracker;
  double sum = 0;
  constexpr int kFrames = 16;
  for (int i = 0; i < kFrames; ++i) {
    BodyScene scene;
    scene.seed = static_cast<std::uint64_t>(i);
    BodyState state = standing(12 * i);
    state.pose.angles.segment<3>(joints()[kRightShoulder].first_angle) = Vec(0, 0.2, 0.6 - 0.9 * std::sin(0.7 * i));
    tracker.track(view_of(state, scene, errors), SE3::Identity(), i / 30.0);
    sum += mean_joint_distance(tracker.state(), state) / kFrames;
  }
  return sum;
}

TEST(DetectedJoints, WrongOnesDoNotHarmWhatIsSeen) {
  const double without = seen_error(std::nullopt);
  EXPECT_LT(seen_error(usual_errors()), without + 0.005);
  EXPECT_LT(seen_error(with_swaps()), without + 0.005);
}

// Somebody who raises an arm, from the side: without joints it is taken for the other arm, of another side.
TEST(DetectedJoints, TellTheFirstFitWhichSideItIs) {
  BodyState truth = standing(235, 1.75);
  truth.pose.angles.segment<3>(joints()[kLeftShoulder].first_angle) = Vec(0, -0.5, 0.5);
  const auto error = [&](const std::optional<DetectorErrors>& errors) {
    return mean_joint_distance(fit_body(view_of(truth, {}, errors), {}, {}).state, truth);
  };
  EXPECT_GT(error(std::nullopt), 0.1);
  for (const double swaps : {0.0, 1.0}) {
    DetectorErrors errors = usual_errors();
    errors.swaps = swaps;
    EXPECT_LT(error(errors), 0.04) << swaps;
  }
}

TEST(DetectedJoints, ThreadsDoNotMatter) {
  const auto run = [](int threads) {
    set_thread_count(threads);
    BodyTracker tracker;
    for (int i = 0; i < 3; ++i) {
      tracker.track(view_of(bending(i), BodyScene(), usual_errors()), SE3::Identity(), i / 30.0);
    }
    set_thread_count(0);
    return tracker.state();
  };
  const BodyState one = run(1);
  const BodyState two = run(2);
  EXPECT_EQ((one.pose.root.matrix() - two.pose.root.matrix()).norm(), 0);
  EXPECT_EQ((one.pose.angles - two.pose.angles).norm(), 0);
  EXPECT_EQ((one.shape - two.shape).norm(), 0);
}

} // namespace
} // namespace kinora::tracking
