// How long a moving camera takes to read its rows, found from what it shows.
#include <cmath>

#include <gtest/gtest.h>

#include "core/velocity.h"
#include "encode/camera_refinement.h"
#include "encode/readout_search.h"
#include "tracking/scenes/room_scene.h"

namespace kinora::encode {
namespace {

using tracking::testing::pose_at;

constexpr double kFrameTime = 1.0 / 30;

using clip::Readout;
using Corrections = std::vector<std::optional<PoseCorrection>>;

/// Each frame says so many seconds of colour and of depth, with that certainty.
void say(double color, double depth, double information, std::size_t frames, Corrections& corrections) {
  PoseCorrection correction;
  correction.readout.information << 2, 0.5, 0.5, 1;
  correction.readout.information *= information;
  correction.readout.gradient = -correction.readout.information * Eigen::Vector2d(color, depth);
  corrections.resize(corrections.size() + frames, correction);
}

TEST(ReadoutBeyond, IsTheMeanOverFramesByTheirCertainty) {
  Corrections corrections;
  for (int i = 0; i < 30; ++i) {
    say(0.010, 0.003, 1, 1, corrections);
    say(0.016, 0, 2, 1, corrections);
    corrections.emplace_back(); // a frame that was not refined
  }
  const auto beyond = readout_beyond(corrections);
  ASSERT_TRUE(beyond);
  EXPECT_NEAR(beyond->color, 0.014, 1e-12);
  EXPECT_NEAR(beyond->depth, 0.001, 1e-12);
}

TEST(ReadoutBeyond, IsToldOnlyOfEnoughFramesThatAgree) {
  const auto certain = [](double early, double late, std::size_t frames) {
    Corrections corrections;
    say(early, 0, 1, frames / 2, corrections);
    say(late, 0, 1, frames - frames / 2, corrections);
    const auto beyond = readout_beyond(corrections);
    return beyond && beyond->is_certain();
  };
  EXPECT_TRUE(certain(0.01, 0.012, 48));
  EXPECT_FALSE(certain(0.01, 0.012, 47));
  EXPECT_FALSE(certain(0.02, -0.01, 48));
  EXPECT_FALSE(certain(0.0015, 0.0015, 48));
  EXPECT_FALSE(readout_beyond(Corrections(60)));
}

/// What a search ends with where a look tells `share` of what is missing.
Readout found(const Readout& truth, double share) {
  ReadoutSearch search(kFrameTime);
  const auto look = [&] {
    Corrections corrections;
    say(share * (truth.color - search.color()), share * (truth.depth - search.depth()), 1, 48, corrections);
    return search.look(corrections);
  };
  if (look()) look();
  return {search.color(), search.depth()};
}

TEST(ReadoutSearch, FindsTheTimesWhateverPartOfThemAFieldTakesIn) {
  for (const Readout& truth : {Readout{0.03, 0}, Readout{0.01, 0.01}, Readout{-0.02, -0.03}}) {
    for (const double share : {0.35, 0.5, 0.9}) {
      EXPECT_NEAR(found(truth, share).color, truth.color, 1e-9) << share;
      EXPECT_NEAR(found(truth, share).depth, truth.depth, 1e-9) << share;
    }
  }
  EXPECT_EQ(found({0, 0.03}, 0.5).color, 0);
  EXPECT_EQ(found({0, 0.03}, 0.5).depth, 0) << "colour that is read at once is not looked at again";
}

TEST(ReadoutSearch, DoesNotBelieveWhatDoesNotVanishOrTakesLongerThanAFrame) {
  EXPECT_NEAR(found({1.1 * kFrameTime, 0}, 0.5).color, kFrameTime, 1e-9);
  EXPECT_EQ(found({1.4 * kFrameTime, 0.01}, 0.5).color, 0);
  EXPECT_EQ(found({1.4 * kFrameTime, 0.01}, 0.5).depth, 0);
  ReadoutSearch search(kFrameTime);
  Corrections always;
  say(0.01, 0, 1, 48, always);
  EXPECT_TRUE(search.look(always));
  EXPECT_FALSE(search.look(always));
  EXPECT_EQ(search.color(), 0);
}

// A hand that carries the camera along and looks about, at a time in frames.
SE3 hand(double t) {
  return pose_at({0.25 * std::sin(0.25 * t), 0.1 * std::sin(0.4 * t), 0.15 * (1 - std::cos(0.2 * t))},
                 4 * std::sin(0.3 * t), 15 * std::sin(0.2 * t), 3 * std::sin(0.4 * t));
}

/// What the refinement finds of a camera that takes so long to read its rows, and knows where it is.
Readout readout_found(const Readout& truth) {
  constexpr int kFrames = 56;
  FramePass pass{{}, fields::PixelStore(1'000'000, kFrames), {}, {}, 0};
  for (int f = 0; f < kFrames; ++f) {
    tracking::testing::RoomOptions room;
    room.width = 96;
    room.height = 72;
    room.focal = 90;
    const Twist velocity = velocity_between(hand(f - 1), hand(f + 1), 2 * kFrameTime);
    room.readout = truth.color * velocity;
    ingest::Frame frame = tracking::testing::render_room(hand(f), f, room);
    room.readout = truth.depth * velocity;
    frame.depth = frame.clean_depth = tracking::testing::render_room(hand(f), f, room).depth;
    pass.clip.times.push_back(f * kFrameTime);
    pass.clip.camera_to_world.push_back(frame.camera.camera_to_world);
    pass.pixels.add(frame, f);
  }
  pass.labels[0].plan = {0, "background", motion::MotionKind::kStill, false, "still"};
  TrainingPlan plan;
  plan.layers.push_back({&pass.labels[0], "background", 1'500'000, 0});
  EncodeOptions options = EncodeOptions::of(Preset::kFast);
  StageTimes times;
  Progress progress;
  const auto refinement = refine_camera(pass, plan, options, times, progress);
  EXPECT_TRUE(refinement);
  return refinement ? refinement->readout : Readout{};
}

class RollingShutter : public ::testing::TestWithParam<Readout> {};

TEST_P(RollingShutter, IsFoundOfColourAndOfDepth) {
  const Readout readout = readout_found(GetParam());
  EXPECT_NEAR(readout.color, GetParam().color, 0.003);
  EXPECT_NEAR(readout.depth, GetParam().depth, 0.005);
}

INSTANTIATE_TEST_SUITE_P(OfColourAndDepth, RollingShutter,
                         ::testing::Values(Readout{0.02, 0.02}, Readout{0.025, 0}, Readout{-0.02, -0.02}));

TEST(GlobalShutter, IsFoundWhereAllRowsAreReadAtOnce) { EXPECT_EQ(readout_found({0, 0}).color, 0); }

} // namespace
} // namespace kinora::encode
