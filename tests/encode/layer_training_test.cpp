// From a followed label to a layer: what each stage leaves in it.
#include "encode/layer_training.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "clip/payloads/field_codec.h"
#include "clip/payloads/touched_entries.h"
#include "core/statistics.h"
#include "encode/motion_smoothing.h"
#include "sheet_astray.h"

namespace kinora::encode {
namespace {

using fields::Performance;

constexpr std::size_t kFewRays = 100'000;

/// The sheet, its nodes tracked beside their places by so many metres.
TrackedLabel tracked_sheet(const Performance& performance, double astray = 0.01) {
  TrackedLabel label;
  label.plan = {1, "sheet", motion::MotionKind::kDeforming, false, "it bends"};
  label.layer =
      tracking::TrackedLayer{testing::astray(performance.motion, astray),
                             testing::edges_of(*performance.motion.graph()), testing::kSpacing, tracking::LayerBody()};
  return label;
}

LayerOutcome trained(const Performance& performance, const TrackedLabel& label, std::size_t rays,
                     std::uint64_t seed = 1) {
  EncodeOptions options = EncodeOptions::of(Preset::kFast);
  options.settings.fields.trainer.seed = seed;
  options.settings.fields.trainer.rays_per_step = 1024;
  StageTimes times;
  Progress progress;
  return train_layer({&label, "sheet", rays, 0}, performance.store, options, times, progress);
}

TEST(LayerTraining, LeavesAMotionThatWasRefinedThroughTheField) {
  const Performance performance;
  const TrackedLabel label = tracked_sheet(performance);
  constexpr std::size_t kRays = 1'200'000;
  const LayerOutcome outcome = trained(performance, label, kRays);
  double tracked = 0;
  double left = 0;
  for (const fields::StoredFrame& frame : performance.store.frames()) {
    const auto f = static_cast<std::size_t>(frame.frame);
    tracked += testing::error_of(label.layer->motion, performance.motion, f);
    left += testing::error_of(outcome.layer.motion, performance.motion, f);
  }
  EXPECT_LT(left, 0.75 * tracked);
  ASSERT_TRUE(outcome.draft);
  EXPECT_EQ(outcome.draft->rays + outcome.trainer.rays, kRays) << "a draft's rays count as the layer's";
}

TEST(LayerTraining, LeavesASmoothMotion) {
  const Performance performance;
  const motion::Motion motion = trained(performance, tracked_sheet(performance, 0.002), kFewRays).layer.motion;
  const motion::Motion smoother = smoothed_in_time(motion);
  std::vector<double> moves; // of nodes, were the motion smoothed again
  for (const std::size_t f : {3U, 4U, 5U}) {
    for (std::size_t n = 0; n < motion.graph()->nodes().size(); ++n) {
      const Eigen::Vector3d& node = motion.graph()->nodes()[n];
      moves.push_back((smoother.deformations()[f].node_to_world[n].to_se3() * node -
                       motion.deformations()[f].node_to_world[n].to_se3() * node)
                          .norm());
    }
  }
  EXPECT_LT(median(moves), 0.0003) << "metres"; // 0.0009 without
}

TEST(LayerTraining, LeavesHowWellCamerasSawEachSide) {
  const Performance performance;
  const LayerOutcome outcome = trained(performance, tracked_sheet(performance), kFewRays);
  ASSERT_TRUE(outcome.layer.confidence);
  constexpr std::size_t kTowardsTheCamera = 4; // of the cube's places: x 0, y 0, z −1
  ASSERT_LT(fields::Confidence::normal(kTowardsTheCamera).z(), -0.9);
  constexpr std::size_t kAway = fields::Confidence::kNormals - 1 - kTowardsTheCamera;
  std::uint8_t front = 0;
  std::uint8_t back = 0;
  for (const auto& levels : outcome.layer.confidence->levels()) {
    front = std::max(front, levels[kTowardsTheCamera]);
    back = std::max(back, levels[kAway]);
  }
  EXPECT_GT(front, fields::Confidence::kMax / 2);
  EXPECT_EQ(back, 0);
}

TEST(LayerTraining, LeavesTablesThatAFileStoresAsTheyAre) {
  const Performance performance;
  const fields::Field field = trained(performance, tracked_sheet(performance), kFewRays).layer.field;
  const fields::Field stored = clip::quantised(field);
  const auto levels = fields::grid_levels(field.config);
  const auto touched = clip::touched_entries(field.config, field.occupancy);
  std::size_t count = 0;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    for (const std::uint32_t entry : touched[l]) {
      for (std::size_t f = 0; f < fields::FieldConfig::kFeatures; ++f, ++count) {
        const std::size_t i = (std::size_t{levels[l].offset} + entry) * fields::FieldConfig::kFeatures + f;
        ASSERT_EQ(stored.table[i], field.table[i]) << l;
      }
    }
  }
  EXPECT_GT(count, 0U);
}

TEST(LayerTraining, AnotherSeedLeavesOtherParametersAndTheSameTheSame) {
  const Performance performance;
  const TrackedLabel label = tracked_sheet(performance);
  const fields::Field once = trained(performance, label, kFewRays).layer.field;
  EXPECT_TRUE(std::ranges::equal(once.table, trained(performance, label, kFewRays).layer.field.table));
  EXPECT_FALSE(std::ranges::equal(once.table, trained(performance, label, kFewRays, 2).layer.field.table));
}

} // namespace
} // namespace kinora::encode
