// Which layers a round of live training is for, and how long it goes on.
#include "encode/live/live_trainer.h"

#include <gtest/gtest.h>

#include "tracking/scenes/synthetic_scene.h"

namespace kinora::encode {
namespace {

constexpr int kWall = 0, kBox = 2; // labels
constexpr std::size_t kRays = 4096;

/// A box that turns before a wall, and what is known of both.
struct Scene {
  std::vector<KeyFrame> frames;
  LiveSnapshot snapshot;

  Scene() {
    tracking::testing::SceneOptions picture;
    picture.width = 80;
    picture.height = 60;
    picture.focal = 80;
    std::vector<motion::Motion::Pose> poses;
    const SE3 first = tracking::testing::pose_at({0, 0, 1}, 15, 0);
    for (int i = 0; i < 3; ++i) {
      const SE3 pose = tracking::testing::pose_at({0, 0, 1}, 15, 20.0 * i);
      frames.push_back({i, std::make_shared<const ingest::Frame>(
                               tracking::testing::render_frame({}, pose, SE3::Identity(), i, picture))});
      poses.push_back({pose * first.inverse(), motion::Health::kTracked});
      snapshot.timeline.times.push_back(frames.back().frame->time);
    }
    snapshot.labels.emplace(kWall, LabelSnapshot{"background", motion::Motion::still(), std::nullopt});
    snapshot.labels.emplace(kBox, LabelSnapshot{"object", motion::Motion::rigid(std::move(poses)), std::nullopt});
  }
};

LiveTrainer make_trainer() {
  EncodeOptions options = EncodeOptions::of(Preset::kFast);
  options.settings.live.training.pixels_per_frame = 4000;
  return LiveTrainer(options);
}

/// Rays that each layer was trained with so far.
std::map<int, std::size_t> rays_of(const LiveTrainer& trainer) {
  std::map<int, std::size_t> rays;
  for (const auto& [label, outcome] : trainer.outcomes()) rays[label] = outcome.training.rays;
  return rays;
}

TEST(LiveTrainer, AllLayersWithoutAFieldComeFirstAndThenInTurns) {
  Scene scene;
  LiveTrainer trainer = make_trainer();
  Progress quiet;
  ASSERT_TRUE(trainer.train(scene.snapshot, scene.frames, kRays, quiet));
  std::map<int, std::size_t> before = rays_of(trainer);
  EXPECT_EQ(before.size(), 2U);
  std::map<int, int> turns;
  int last = -1, in_a_row = 0;
  for (int round = 0; round < 8; ++round) {
    ASSERT_TRUE(trainer.train(scene.snapshot, scene.frames, kRays, quiet));
    const std::map<int, std::size_t> after = rays_of(trainer);
    std::size_t gained = 0;
    for (const auto& [label, rays] : after) {
      if (rays == before[label]) continue;
      ++turns[label];
      in_a_row = label == last ? in_a_row + 1 : 1;
      last = label;
      gained += rays - before[label];
    }
    EXPECT_GE(gained, kRays) << "one layer has the whole round";
    EXPECT_LE(in_a_row, 2) << "two layers whose parts are alike";
    before = after;
  }
  EXPECT_EQ(turns[kWall] + turns[kBox], 8) << "one layer each round";
  EXPECT_GE(turns[kWall], 1);
  EXPECT_GE(turns[kBox], 1);
}

TEST(LiveTrainer, AViewsBurstAndTheLastRoundAreForAllLayers) {
  Scene scene;
  LiveTrainer trainer = make_trainer();
  Progress quiet;
  trainer.train(scene.snapshot, scene.frames, kRays, quiet);
  const std::map<int, std::size_t> first = rays_of(trainer);
  trainer.refine(scene.snapshot, scene.frames, kRays, quiet);
  const std::map<int, std::size_t> refined = rays_of(trainer);
  scene.snapshot.is_last = true;
  trainer.train(scene.snapshot, scene.frames, kRays, quiet);
  const std::map<int, std::size_t> last = rays_of(trainer);
  for (const int label : {kWall, kBox}) {
    EXPECT_GT(refined.at(label), first.at(label)) << label;
    EXPECT_GT(last.at(label), refined.at(label)) << label;
  }
}

TEST(LiveTrainer, ALayerThatAppearsIsTrainedAtOnce) {
  Scene scene;
  LiveTrainer trainer = make_trainer();
  Progress quiet;
  const LabelSnapshot box = scene.snapshot.labels.at(kBox);
  scene.snapshot.labels.erase(kBox);
  trainer.train(scene.snapshot, scene.frames, kRays, quiet);
  EXPECT_EQ(rays_of(trainer).count(kBox), 0U);
  scene.snapshot.labels.emplace(kBox, box);
  trainer.train(scene.snapshot, scene.frames, kRays, quiet);
  EXPECT_GE(rays_of(trainer)[kBox], kRays);
}

TEST(LiveTrainer, ARoundHasManySmallSteps) {
  Scene scene;
  LiveTrainer trainer = make_trainer();
  Progress quiet;
  for (int round = 0; round < 3; ++round) trainer.train(scene.snapshot, scene.frames, kRays, quiet);
  for (const auto& [label, outcome] : trainer.outcomes())
    EXPECT_LE(outcome.training.rays, 256 * outcome.training.steps) << label;
}

} // namespace
} // namespace kinora::encode
