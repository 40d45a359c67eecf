// Where things are put in frames that nothing was learnt of.
#include "encode/held_out_poses.h"

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "encode/held_out_frames.h"
#include "ingest/capture/frames_capture.h"

namespace kinora::encode {
namespace {

using motion::Health;
using motion::Motion;

constexpr int kFrames = 20;
constexpr double kFramesPerSecond = 30;
constexpr std::size_t kFifth = 4; // held out
constexpr std::size_t kLast = 19; // held out, too

/// Once around a circle of 40 cm in a second, turning all the while: 1.3 m/s, and 8 m/s² aside.
SE3 on_circle(double frame, double radius = 0.2) {
  const double angle = 2 * std::numbers::pi * frame / kFramesPerSecond;
  SE3 pose = SE3::Identity();
  pose.translate(
      Eigen::Vector3d(radius * std::cos(angle), 0.1 * radius * std::sin(2 * angle), 1.5 + radius * std::sin(angle)));
  pose.rotate(Eigen::AngleAxisd(angle, Eigen::Vector3d(0.1, 1, 0.2).normalized()));
  return pose;
}

double distance(const SE3& a, const SE3& b) { return (a.translation() - b.translation()).norm(); }

/// Frames whose pictures are all of one grey.
std::unique_ptr<ingest::Capture> held_out_of_five(std::uint8_t grey, const std::function<SE3(int)>& camera) {
  std::vector<ingest::Frame> frames(kFrames);
  for (int i = 0; i < kFrames; ++i) {
    ingest::Frame& frame = frames[static_cast<std::size_t>(i)];
    frame.camera = {{8, 8, 8, 8, 4, 4}, camera(i)};
    frame.color = ColorImage(8, 8, 3, grey);
    frame.depth = frame.clean_depth = DepthImage(8, 8, 1, static_cast<float>(grey));
    frame.labels = LabelImage(8, 8, 1, static_cast<std::uint8_t>(grey % 3));
  }
  const HeldOutFrames held_out{5};
  return frames_where(std::make_unique<ingest::testing::FramesCapture>(std::move(frames)),
                      [held_out](int index) { return held_out.contains(index); });
}

/// A rigid thing and one of two nodes, with a joint, on circles of different size; frames 4, 9, … are not in it.
clip::Clip clip_of_the_others(const std::set<int>& lost = {}) {
  clip::Clip clip;
  clip.metadata["start_seconds"] = 0.0;
  clip.camera_to_world = {SE3::Identity()};
  std::vector<Motion::Pose> poses;
  std::vector<Motion::Deformation> deformations;
  motion::JointPaths joints{{"hand"}, {}};
  for (int i = 0; i < kFrames; ++i) {
    if (HeldOutFrames{5}.contains(i)) continue;
    clip.times.push_back(i / kFramesPerSecond);
    clip.capture_frames.push_back(i);
    clip.held_out.push_back(false);
    const Health health = lost.contains(i) ? Health::kLost : Health::kTracked;
    poses.push_back({on_circle(i), health});
    deformations.push_back({{DualQuaternion::from(on_circle(i)), DualQuaternion::from(on_circle(i, 0.1))}, health});
    joints.positions.push_back({on_circle(i).translation()});
  }
  const auto graph = std::make_shared<motion::DeformationGraph>(
      std::vector{Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.1, 0, 0)}, 0.1, 0.2);
  clip.layers.push_back({"background", 0, {}, Motion::still()});
  clip.layers.push_back({"object", 2, {}, Motion::rigid(std::move(poses))});
  clip.layers.push_back({"person", 1, {}, Motion::deforming(graph, std::move(deformations))});
  clip.layers.back().joints = std::move(joints);
  return clip;
}

clip::Clip with_held_out(clip::Clip clip, std::uint8_t grey = 100, const std::function<SE3(int)>& camera = {}) {
  Progress progress;
  const auto held_out = held_out_of_five(
      grey, camera ? camera : [](int) { return SE3::Identity(); });
  add_held_out_frames(clip, *held_out, camera ? std::optional(std::vector<SE3>()) : std::nullopt, progress);
  return clip;
}

TEST(HeldOutPoses, LieOnTheCurveThatTheirNeighboursTell) {
  const clip::Clip clip = with_held_out(clip_of_the_others());
  ASSERT_EQ(clip.times.size(), std::size_t{kFrames});
  for (const std::size_t i : {kFifth, std::size_t{9}, std::size_t{14}}) {
    SCOPED_TRACE(i);
    const double frame = static_cast<double>(i);
    EXPECT_GT(distance(interpolate(on_circle(frame - 1), on_circle(frame + 1), 0.5), on_circle(frame)), 0.001)
        << "half way between two frames is no answer";
    const Motion::Pose& pose = clip.layers[1].motion.poses()[i];
    EXPECT_LT(distance(pose.canonical_to_world, on_circle(frame)), 0.0003);
    EXPECT_LT(rotation_angle(pose.canonical_to_world.inverse() * on_circle(frame)), 0.001);
    const Motion::Deformation& nodes = clip.layers[2].motion.deformations()[i];
    EXPECT_LT(distance(nodes.node_to_world[0].to_se3(), on_circle(frame)), 0.0003);
    EXPECT_LT(distance(nodes.node_to_world[1].to_se3(), on_circle(frame, 0.1)), 0.0003);
    EXPECT_LT((clip.layers[2].joints->positions[i][0] - on_circle(frame).translation()).norm(), 0.0003);
    EXPECT_EQ(pose.health, Health::kHeld) << "nobody saw it";
    EXPECT_EQ(nodes.health, Health::kHeld);
  }
}

TEST(HeldOutPoses, StandInTheirTimeAndAloneAreMarked) {
  const clip::Clip before = clip_of_the_others();
  const clip::Clip clip = with_held_out(before);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < clip.times.size(); ++i) {
    EXPECT_DOUBLE_EQ(clip.times[i], static_cast<double>(i) / kFramesPerSecond);
    EXPECT_EQ(clip.capture_frames[i], static_cast<int>(i));
    EXPECT_EQ(clip.held_out[i], i % 5 == 4);
    if (clip.held_out[i]) continue;
    EXPECT_EQ(clip.layers[1].motion.poses()[i].canonical_to_world.matrix(),
              before.layers[1].motion.poses()[kept].canonical_to_world.matrix());
    EXPECT_EQ(clip.layers[2].joints->positions[i], before.layers[2].joints->positions[kept]);
    ++kept;
  }
  EXPECT_EQ(kept, before.times.size());
  EXPECT_EQ(clip.camera_to_world.size(), 1U);
}

TEST(HeldOutPoses, KeepWhenLayersAreThereAndNodesAreBorn) {
  clip::Clip before = clip_of_the_others();
  before.layers[0].presence = motion::Presence::away_during({{0, 4}, {7, 9}}); // frames 0 to 3, 8 and 10
  before.layers[2].births = motion::NodeBirths({0, 5});
  const clip::Clip clip = with_held_out(before);
  EXPECT_EQ(clip.layers[0].presence.away(), (std::vector<motion::FrameSpan>{{0, 4}, {8, 11}}));
  EXPECT_EQ(clip.layers[2].births, motion::NodeBirths({0, 6}));
  EXPECT_TRUE(clip.layers[1].presence.is_always());
}

TEST(HeldOutPoses, DependOnNothingThatTheFramesShow) {
  const clip::Clip a = with_held_out(clip_of_the_others(), 1);
  const clip::Clip b = with_held_out(clip_of_the_others(), 200);
  for (std::size_t i = 0; i < a.times.size(); ++i) {
    EXPECT_EQ(a.layers[1].motion.poses()[i].canonical_to_world.matrix(),
              b.layers[1].motion.poses()[i].canonical_to_world.matrix());
    for (std::size_t n = 0; n < 2; ++n) {
      const DualQuaternion& node = a.layers[2].motion.deformations()[i].node_to_world[n];
      const DualQuaternion& other = b.layers[2].motion.deformations()[i].node_to_world[n];
      EXPECT_EQ(node.real.coeffs(), other.real.coeffs());
      EXPECT_EQ(node.dual.coeffs(), other.dual.coeffs());
    }
  }
}

TEST(HeldOutPoses, BeyondTheLastFrameGoOnAsBetweenTheLastTwo) {
  const clip::Clip clip = with_held_out(clip_of_the_others());
  const SE3& found = clip.layers[1].motion.poses()[kLast].canonical_to_world;
  const SE3 last = on_circle(18);
  EXPECT_LT(distance(found, last * on_circle(17).inverse() * last), 1e-9);
  EXPECT_LT(distance(found, on_circle(19)), 0.02);
  EXPECT_GT(distance(last, on_circle(19)), 0.03);
}

TEST(HeldOutPoses, AreLostBesideAFrameInWhichTheThingIsLost) {
  const clip::Clip clip = with_held_out(clip_of_the_others({5, 12}));
  EXPECT_EQ(clip.layers[1].motion.poses()[kFifth].health, Health::kLost);
  EXPECT_EQ(clip.layers[2].motion.deformations()[kFifth].health, Health::kLost);
  const Motion::Pose& pose = clip.layers[1].motion.poses()[14]; // 12 is two before
  EXPECT_EQ(pose.health, Health::kHeld);
  EXPECT_LT(distance(pose.canonical_to_world, on_circle(14)), 0.002) << "of the other three";
}

TEST(HeldOutPoses, CameraIsWhereTheFrameKnowsItOrOnItsPath) {
  const auto camera = [](int i) { return on_circle(i, 0.05); };
  clip::Clip carried = clip_of_the_others();
  carried.camera_to_world.clear();
  for (const int frame : carried.capture_frames) carried.camera_to_world.push_back(camera(frame));
  const clip::Clip told = with_held_out(carried, 100, camera);
  EXPECT_EQ(told.camera_to_world[kFifth].matrix(), camera(kFifth).matrix());
  const clip::Clip found = with_held_out(carried);
  ASSERT_EQ(found.camera_to_world.size(), std::size_t{kFrames});
  EXPECT_NE(found.camera_to_world[kFifth].matrix(), camera(kFifth).matrix());
  EXPECT_LT(distance(found.camera_to_world[kFifth], camera(kFifth)), 0.0003);
}

TEST(HeldOutPoses, CameraThatTheFrameKnowsMovesAsThoseBesideItWereMoved) {
  clip::Clip clip = clip_of_the_others();
  SE3 known(Eigen::Translation3d(0, 0, 1));
  const SE3 move(Eigen::Translation3d(0.01, 0, 0) * Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY()));
  clip.camera_to_world.assign(clip.times.size(), move * known);
  Progress progress;
  const auto held_out = held_out_of_five(100, [&](int) { return known; });
  add_held_out_frames(clip, *held_out, std::vector<SE3>(clip.times.size(), move), progress);
  ASSERT_EQ(clip.camera_to_world.size(), std::size_t{kFrames});
  for (const SE3& pose : clip.camera_to_world) EXPECT_TRUE(pose.isApprox(move * known, 1e-9));
}

} // namespace
} // namespace kinora::encode
