// Losses are trusted as far as the views of a layer agree.
#include <gtest/gtest.h>

#include "fields/planning/view_consistency.h"
#include "fields/scenes/analytic_scene.h"

namespace kinora::fields {
namespace {

constexpr int kBall = 2;

/// Twelve views of the ball, every other one from a camera that stands elsewhere than it says.
PixelStore misplaced(double metres) {
  const Scene scene;
  PixelStore store(1'000'000, 12);
  for (int i = 0; i < 12; ++i) {
    ingest::Frame frame = scene.frame(i, 0.05 * (i - 6));
    if (i % 2 == 1) frame.camera.camera_to_world.translation() += Eigen::Vector3d(metres, 0, 0);
    store.add(frame, i);
  }
  return store;
}

TEST(ViewConsistency, IsFullWhereAllViewsAreTrue) {
  const ViewConsistency consistency = measure_view_consistency({misplaced(0), kBall, motion::Motion::still()});
  EXPECT_GT(consistency.observations, 1000U);
  EXPECT_EQ(consistency.free_space_violations, 0);
  EXPECT_LT(consistency.noise, 0.1) << "although a ball is slanted nearly everywhere";
  TrainerConfig trainer;
  adapt_to(consistency, {}, trainer);
  EXPECT_TRUE(trainer.exact_depth);
  EXPECT_FALSE(trainer.carve_free_space);
  const LossWeights weights = weights_for(consistency);
  EXPECT_FLOAT_EQ(weights.opacity, 2 * LossWeights{}.opacity);
  EXPECT_FLOAT_EQ(weights.depth, 2 * LossWeights{}.depth);
  EXPECT_FLOAT_EQ(weights.free_space, LossWeights{}.free_space);
  EXPECT_FLOAT_EQ(weights.free_space_rays, LossWeights{}.free_space_rays / 2);
}

TEST(ViewConsistency, IsLostWithWrongPoses) {
  const ViewConsistency consistency = measure_view_consistency({misplaced(0.2), kBall, motion::Motion::still()});
  EXPECT_GT(consistency.free_space_violations, 0.05);
  TrainerConfig trainer;
  adapt_to(consistency, {}, trainer);
  EXPECT_FALSE(trainer.exact_depth);
  EXPECT_TRUE(trainer.carve_free_space);
  EXPECT_FLOAT_EQ(weights_for(consistency).opacity, LossWeights{}.opacity);
}

TEST(ViewConsistency, IsNotClaimedOfASingleView) {
  PixelStore store(1'000'000, 1);
  store.add(Scene{}.frame(0, 0), 0);
  const ViewConsistency consistency = measure_view_consistency({store, kBall, motion::Motion::still()});
  EXPECT_EQ(consistency.observations, 0U);
  TrainerConfig trainer;
  adapt_to(consistency, {}, trainer);
  EXPECT_FALSE(trainer.exact_depth);
  EXPECT_FLOAT_EQ(weights_for(consistency).opacity, LossWeights{}.opacity);
}

/// Twelve views whose depths are off by so many standard deviations of the sensor.
PixelStore noisy(double deviations) {
  const Scene scene;
  PixelStore store(1'000'000, 12);
  for (int i = 0; i < 12; ++i) {
    ingest::Frame frame = scene.frame(i, 0.05 * (i - 6));
    Random random(5, static_cast<std::uint64_t>(i));
    for (float& depth : frame.depth.values()) {
      depth += static_cast<float>(deviations * kSensorNoise.sigma(depth) * random.normal());
    }
    frame.clean_depth = frame.depth;
    store.add(frame, i);
  }
  return store;
}

TEST(ViewConsistency, MeasuresNoiseAndWidensBandsWithIt) {
  for (const double deviations : {0.5, 1.0, 3.0, 5.0}) {
    const ViewConsistency consistency = measure_view_consistency({noisy(deviations), kBall, motion::Motion::still()});
    EXPECT_NEAR(consistency.noise, deviations, 0.3 * deviations);
    TrainerConfig trainer;
    adapt_to(consistency, {}, trainer);
    EXPECT_FALSE(trainer.exact_depth);
  }
  EXPECT_EQ(weights_for({1000, 0, 0.4}).noise.scale, 1);
  EXPECT_EQ(weights_for({1000, 0, 2.5}).noise.scale, 2.5F);
  EXPECT_LT(weights_for({1000, 0, 1000}).noise.scale, 10);
  const PixelStore store = noisy(3);
  const auto still = motion::Motion::still();
  const LayerObservations ball{store, kBall, still};
  const FieldConfig config = choose_field_config(ball);
  const RaySampler narrow(ball, config, {});
  const RaySampler wide(ball, config, {}, SensorNoise{3});
  EXPECT_GT(wide.occupancy().count(), narrow.occupancy().count());
}

TEST(ViewConsistency, FallsInProportion) {
  EXPECT_GT(weights_for({1000, 0.001, 1}).opacity, weights_for({1000, 0.003, 1}).opacity);
  EXPECT_GT(weights_for({1000, 0.003, 1}).opacity, weights_for({1000, 0.1, 1}).opacity);
}

} // namespace
} // namespace kinora::fields
