// Somebody carries a box behind a screen, and comes out with it elsewhere: the camera sees the arm down to the wrist.
#include "encode/scene_tracker.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "core/sensor_noise.h"
#include "tracking/body/synthetic_body.h"
#include "tracking/scenes/synthetic_scene.h"

namespace kinora::encode {
namespace {

using Vec = Eigen::Vector3d;
using tracking::BodyState;
using tracking::kRightElbow;
using tracking::kRightShoulder;
using tracking::kRightWrist;
using tracking::testing::BodyScene;
using tracking::testing::Shape;
using tracking::testing::ShapeKind;

// Of 24 × 12 × 9 cm; the hand holds one end of it.
const Shape kBox{ShapeKind::kBox, {0.12, 0.06, 0.045}, true};
constexpr int kFrames = 38;
constexpr int kHidden = 19; // from here on, all of it,
constexpr int kShown = 33;  // to here
constexpr int kLetGo = 24;  // if it is

// How far a motion from one frame to another has got.
double phase(int frame, int from, int to) {
  return std::clamp(static_cast<double>(frame - from) / (to - from), 0.0, 1.0);
}

// The right arm waves, goes down behind the screen, swings there towards the body, and then bends.
BodyState person_at(int frame) {
  BodyState state = tracking::testing::standing(0);
  const double lowered =
      0.35 + 0.2 * std::sin(0.5 * std::min(frame, 12)) + 0.75 * phase(frame, 12, 20) + 0.3 * phase(frame, 20, 30);
  const double forwards = 0.2 + 0.3 * phase(frame, 20, 30);
  state.pose.angles.segment<3>(tracking::joints()[kRightShoulder].first_angle) = Vec(0, forwards, lowered);
  state.pose.angles[tracking::joints()[kRightElbow].first_angle] = 0.2 + 1.7 * phase(frame, 30, 40);
  return state;
}

SE3 box_at(int frame, bool is_let_go) {
  const BodyState state = person_at(is_let_go ? std::min(frame, kLetGo) : frame);
  return forward_kinematics(state.pose, state.shape)[kRightWrist] * Eigen::Translation3d(-0.22, 0, 0);
}

ingest::Frame frame_at(int frame, bool is_let_go) {
  BodyScene scene;
  scene.width = 320;
  scene.height = 240;
  scene.focal = 300;
  scene.noise = 0;
  ingest::Frame picture = render_body(person_at(frame), scene);
  const SE3 to_box = box_at(frame, is_let_go).inverse();
  Random random(7, static_cast<std::uint64_t>(frame));
  for (int v = 0; v < scene.height; ++v) {
    for (int u = 0; u < scene.width; ++u) {
      const Vec ray = picture.camera.intrinsics.unproject(u, v, 1);
      float& z = picture.depth.at(u, v);
      const auto hit = intersect(kBox, to_box.translation(), to_box.linear() * ray);
      if (hit && *hit < z) {
        z = static_cast<float>(*hit);
        picture.labels.at(u, v) = 2;
        const Vec at = to_box * (*hit * ray);
        const double level = 120 + 40 * std::sin(90 * at.x() + 50 * at.y()) + 40 * std::sin(70 * at.y() - 60 * at.z());
        for (int c = 0; c < 3; ++c) picture.color.at(u, v, c) = static_cast<std::uint8_t>(level);
      }
      if (ray.x() < -0.08 && ray.y() > 0) {
        z = 1.6F;
        picture.labels.at(u, v) = 0;
        for (int c = 0; c < 3; ++c) picture.color.at(u, v, c) = 60;
      }
      z += static_cast<float>(kSensorNoise.sigma(z) * random.normal());
    }
  }
  picture.clean_depth = picture.depth;
  picture.index = frame;
  picture.time = frame / 30.0;
  return picture;
}

/// The box's poses, where it and the person are followed together.
std::vector<motion::Motion::Pose> follow(bool is_let_go) {
  ingest::CaptureInfo capture;
  capture.labels[2] = {"box", "rigid", ""};
  Progress progress;
  StageTimes times;
  SceneTracker scene(capture, {}, progress);
  for (int i = 0; i < kFrames; ++i) scene.add(frame_at(i, is_let_go), times);
  return std::move(scene).finish(times).at(2).poses;
}

TEST(HeldObject, GoesWithTheHandThatHoldsItWhileItIsHidden) {
  const std::vector<motion::Motion::Pose> poses = follow(false);
  const SE3 first = box_at(0, false);
  for (int i = 0; i < kFrames; ++i) {
    const motion::Motion::Pose& pose = poses[static_cast<std::size_t>(i)];
    const SE3 truth = box_at(i, false);
    const bool is_hidden = i >= kHidden && i < kShown;
    if (is_hidden) {
      EXPECT_EQ(pose.health, motion::Health::kHeld) << i;
    }
    if (i > kShown) {
      EXPECT_EQ(pose.health, motion::Health::kTracked) << i;
    }
    // Where it was seen last it was 55 cm off in the end, and it was not found again.
    EXPECT_LT((pose.canonical_to_world * first.translation() - truth.translation()).norm(), 0.03) << i;
  }
}

TEST(HeldObject, StaysBehindOnceTheCameraSeesThatItIsNotInTheHand) {
  const std::vector<motion::Motion::Pose> poses = follow(true);
  EXPECT_EQ(poses.back().health, motion::Health::kHeld);
  EXPECT_EQ(poses[kFrames - 1].canonical_to_world.matrix(), poses[kFrames - 4].canonical_to_world.matrix());
  EXPECT_NE(poses[kLetGo + 2].canonical_to_world.matrix(), poses[kLetGo].canonical_to_world.matrix());
}

} // namespace
} // namespace kinora::encode
