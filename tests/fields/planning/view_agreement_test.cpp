// Losses are trusted as far as the views of a layer agree.
#include <gtest/gtest.h>

#include "fields/planning/view_agreement.h"
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

TEST(ViewAgreement, IsFullWhereAllViewsAreTrue) {
  const ViewAgreement agreement = agreement_of_views({misplaced(0), kBall, motion::Motion::still()});
  EXPECT_GT(agreement.looks, 1000U);
  EXPECT_EQ(agreement.seen_through, 0);
  EXPECT_LT(agreement.noise, 0.1) << "although a ball is slanted nearly everywhere";
  TrainerConfig trainer;
  adapt_to(agreement, {}, trainer);
  EXPECT_TRUE(trainer.exact_depth);
  EXPECT_FALSE(trainer.drop_stray_cells);
  const LossWeights weights = weights_for(agreement);
  EXPECT_FLOAT_EQ(weights.opacity, 2 * LossWeights{}.opacity);
  EXPECT_FLOAT_EQ(weights.depth, 2 * LossWeights{}.depth);
  EXPECT_FLOAT_EQ(weights.emptiness, LossWeights{}.emptiness);
  EXPECT_FLOAT_EQ(weights.empty_rays, LossWeights{}.empty_rays / 2);
}

TEST(ViewAgreement, IsLostWithWrongPoses) {
  const ViewAgreement agreement = agreement_of_views({misplaced(0.2), kBall, motion::Motion::still()});
  EXPECT_GT(agreement.seen_through, 0.05);
  TrainerConfig trainer;
  adapt_to(agreement, {}, trainer);
  EXPECT_FALSE(trainer.exact_depth);
  EXPECT_TRUE(trainer.drop_stray_cells);
  EXPECT_FLOAT_EQ(weights_for(agreement).opacity, LossWeights{}.opacity);
}

TEST(ViewAgreement, IsNotClaimedOfASingleView) {
  PixelStore store(1'000'000, 1);
  store.add(Scene{}.frame(0, 0), 0);
  const ViewAgreement agreement = agreement_of_views({store, kBall, motion::Motion::still()});
  EXPECT_EQ(agreement.looks, 0U);
  TrainerConfig trainer;
  adapt_to(agreement, {}, trainer);
  EXPECT_FALSE(trainer.exact_depth);
  EXPECT_FLOAT_EQ(weights_for(agreement).opacity, LossWeights{}.opacity);
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

TEST(ViewAgreement, MeasuresNoiseAndWidensBandsWithIt) {
  for (const double deviations : {0.5, 1.0, 3.0, 5.0}) {
    const ViewAgreement agreement = agreement_of_views({noisy(deviations), kBall, motion::Motion::still()});
    EXPECT_NEAR(agreement.noise, deviations, 0.3 * deviations);
    TrainerConfig trainer;
    adapt_to(agreement, {}, trainer);
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
  const RaySampler wide(ball, config, {}, 3);
  EXPECT_GT(wide.occupancy().count(), narrow.occupancy().count());
}

TEST(ViewAgreement, FallsInProportion) {
  EXPECT_GT(weights_for({1000, 0.001, 1}).opacity, weights_for({1000, 0.003, 1}).opacity);
  EXPECT_GT(weights_for({1000, 0.003, 1}).opacity, weights_for({1000, 0.1, 1}).opacity);
}

} // namespace
} // namespace kinora::fields
