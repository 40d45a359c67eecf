#include "tracking/deforming/layer_body.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "motion/point_track.h"
#include "tracking/body/synthetic_body.h"
#include "tracking/deforming/deforming_tracker.h"
#include "tracking/scenes/bending_plate.h"
#include "tracking/view/deforming_view.h"

namespace kinora::tracking {
namespace {

using testing::BodyScene;
using testing::render_body;
using testing::standing;

constexpr double kInterval = 1.0 / 30;

// Stretches the left forearm out to the side, then bends it upwards behind something.
BodyState bending(int frame) {
  BodyState state = standing(0);
  state.pose.angles.segment<3>(joints()[kLeftShoulder].first_angle) = Eigen::Vector3d(0, -0.2, -0.6);
  state.pose.angles[joints()[kLeftElbow].first_angle] = 0.3 + 0.03 * std::max(0, frame - 12);
  return state;
}

ingest::Frame frame_of(const BodyState& state, int number, BodyScene scene = {}) {
  scene.seed = static_cast<std::uint64_t>(number);
  ingest::Frame frame = render_body(state, scene);
  frame.index = number;
  frame.time = number * kInterval;
  return frame;
}

LayerBody body_after(const std::vector<ingest::Frame>& frames, int label) {
  LayerBody body;
  for (const ingest::Frame& frame : frames) body.track(view_layer(frame, label), SE3::Identity(), frame.time);
  return body;
}

std::vector<ingest::Frame> person() {
  std::vector<ingest::Frame> frames(12);
  for (int i = 0; i < 12; ++i) frames[static_cast<std::size_t>(i)] = frame_of(bending(i), i);
  return frames;
}

std::vector<ingest::Frame> plate() {
  testing::SceneOptions options;
  options.width = 160;
  options.height = 120;
  options.focal = 160;
  std::vector<ingest::Frame> frames;
  for (int i = 0; i < 12; ++i) {
    testing::Plate plate;
    plate.to_world = SE3(Eigen::Translation3d(0, 0, 1));
    plate.curvature = 0.1 * i;
    frames.push_back(testing::render_plate(plate, SE3::Identity(), i, options));
  }
  return frames;
}

TEST(LayerBody, KnowsAPersonAndItsJoints) {
  const LayerBody body = body_after(person(), 1);
  EXPECT_EQ(body.verdict(), BodyVerdict::kPerson) << body.explained() << ' ' << body.free_space();
  const auto paths = body.joint_paths();
  ASSERT_TRUE(paths);
  ASSERT_EQ(paths->positions.size(), 12U);
  ASSERT_EQ(paths->names.size(), static_cast<std::size_t>(kJoints));
  EXPECT_EQ(paths->names[kLeftWrist], "left_wrist");
  const Bones truth = forward_kinematics(bending(11).pose, bending(11).shape);
  for (std::size_t j = 0; j < kJoints; ++j) {
    EXPECT_LT((paths->positions[11][j] - truth[j].translation()).norm(), 0.08) << paths->names[j];
  }
}

TEST(LayerBody, TakesNoClothForAPerson) {
  const LayerBody body = body_after(plate(), 2);
  EXPECT_EQ(body.verdict(), BodyVerdict::kNobody) << body.explained() << ' ' << body.free_space();
  EXPECT_FALSE(body.joint_paths());
}

TEST(LayerBody, DecidesNothingByAFewFrames) {
  std::vector<ingest::Frame> few = person();
  few.resize(3);
  const LayerBody body = body_after(few, 1);
  EXPECT_EQ(body.verdict(), BodyVerdict::kUndecided);
  EXPECT_TRUE(body.targets(2, SE3::Identity()).empty());
}

motion::Motion follow(const std::vector<ingest::Frame>& frames, int label, bool use_body) {
  DeformingTrackerConfig config;
  config.binding.use_body = use_body;
  DeformingTracker tracker(label, config);
  for (const ingest::Frame& frame : frames) tracker.track(frame);
  return std::move(tracker).finish().value().motion;
}

void expect_same(const motion::Motion& a, const motion::Motion& b) {
  ASSERT_EQ(a.graph()->nodes(), b.graph()->nodes());
  for (std::size_t f = 0; f < a.deformations().size(); ++f) {
    for (std::size_t n = 0; n < a.graph()->nodes().size(); ++n) {
      EXPECT_EQ(a.deformations()[f].node_to_world[n].dual.coeffs(), b.deformations()[f].node_to_world[n].dual.coeffs());
    }
  }
}

TEST(DeformingTrackerWithBody, ABodyThatIsNoneChangesNothing) {
  expect_same(follow(plate(), 2, true), follow(plate(), 2, false));
}

/// Twelve frames in which all is seen, then an arm that bends by degrees, at last behind something.
std::vector<ingest::Frame> arm_into_hiding() {
  std::vector<ingest::Frame> frames = person();
  BodyScene covered;
  covered.cover = testing::Cover{152, 20, 210, 130};
  for (int i = 12; i < 24; ++i) frames.push_back(frame_of(bending(i), i, i < 16 ? BodyScene() : covered));
  return frames;
}

// Mean error of a point on the left forearm over the frames in which it is hidden, metres.
double hidden_error(const std::vector<ingest::Frame>& frames, const motion::Motion& motion) {
  const Eigen::Vector3d local(0.15, 0, 0.035);
  const auto position = [&](int frame) {
    return Eigen::Vector3d(forward_kinematics(bending(frame).pose, bending(frame).shape)[kLeftElbow] * local);
  };
  const auto track = motion::track_point(motion, frames.size(), 0, position(0));
  double sum = 0;
  int count = 0;
  for (int frame = 16; frame < static_cast<int>(frames.size()); ++frame, ++count) {
    sum += (track[static_cast<std::size_t>(frame)] - position(frame)).norm();
  }
  return sum / count;
}

TEST(DeformingTrackerWithBody, AHiddenForearmFollowsItsBone) {
  const std::vector<ingest::Frame> frames = arm_into_hiding();
  const double with = hidden_error(frames, follow(frames, 1, true));
  const double without = hidden_error(frames, follow(frames, 1, false));
  EXPECT_LT(with, 0.8 * without) << without;
  EXPECT_LT(with, 0.05);
}

TEST(DeformingTrackerWithBody, IsTheSameForOneThreadAndTwo) {
  const std::vector<ingest::Frame> frames = arm_into_hiding();
  std::vector<motion::Motion> motions;
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    motions.push_back(follow(frames, 1, true));
  }
  set_thread_count(0);
  expect_same(motions[0], motions[1]);
}

} // namespace
} // namespace kinora::tracking
