// What a field that has learnt does with a measurement that it knows better than.
#include <gtest/gtest.h>

#include "fields/scenes/painted_field.h"
#include "fields/training/ray_refinement.h"

namespace kinora::fields {
namespace {

constexpr double kWall = 0.5; // metres; the box begins where rays do
constexpr float kBand = 0.06F;
constexpr std::size_t kProbes = 4;

struct Refined {
  Field field =
      testing::painted_field({{0, 0, 0}, 1}, [](const Eigen::Vector3d& p) { return testing::Paint{kWall - p.z()}; });
  RayBatch rays;

  /// A ray along z that measured this depth, with samples in the middle of each part of its band.
  void add(float measured) {
    RayTarget target;
    target.depth = measured;
    target.inverse_band = 1 / kBand;
    const float step = 2 * kBand / kProbes;
    for (std::size_t i = 0; i < kProbes; ++i) append(measured - kBand + step * (static_cast<float>(i) + 0.5F), step);
    rays.end_ray(target);
  }
  void append(float depth, float length) {
    const auto lengths = length / static_cast<float>(field.config.density_length());
    rays.samples.push_back({{0.4F, 0.6F, depth}, depth, lengths});
  }
  void refine() {
    RefinementScratch scratch;
    refine_rays(field, grid_levels(field.config), rays, scratch);
  }
  std::span<const RaySample> samples(std::size_t ray) const {
    return {rays.samples.data() + rays.first_sample[ray], rays.samples.data() + rays.first_sample[ray + 1]};
  }
};

TEST(RayRefinement, MovesSamplesToTheSurface) {
  for (const float error : {-0.03F, 0.03F}) {
    Refined refined;
    const float measured = static_cast<float>(kWall) + error;
    refined.add(measured);
    refined.refine();
    ASSERT_EQ(refined.rays.ray_count(), 1U);
    const auto samples = refined.samples(0);
    ASSERT_EQ(samples.size(), kRefinedSamples);
    float mean = 0;
    for (const RaySample& sample : samples) {
      EXPECT_FLOAT_EQ(sample.position[0], 0.4F);
      EXPECT_NEAR(sample.position[2], sample.depth, 1e-6F); // the ray is the same
      mean += sample.depth / kRefinedSamples;
    }
    EXPECT_LT(std::abs(mean - static_cast<float>(kWall)), 0.7F * std::abs(error)) << error;
    EXPECT_LT(samples.back().depth - samples.front().depth, kBand);
    // They stand for the whole of the narrower band.
    const float length = samples[0].length + samples[1].length + samples[2].length;
    EXPECT_NEAR(length * static_cast<float>(refined.field.config.density_length()), kBand, 1e-5F);
    const float moved = (refined.rays.targets[0].depth - measured) / -error;
    EXPECT_GT(moved, 0.05F) << error;
    EXPECT_LT(moved, 0.5F) << error;
  }
}

TEST(RayRefinement, TakesOutWhatIsMeasuredInEmptySpace) {
  Refined refined;
  refined.add(0.2F);
  refined.add(static_cast<float>(kWall));
  refined.rays.targets[1].color = {1, 0, 0};
  refined.refine();
  ASSERT_EQ(refined.rays.ray_count(), 1U);
  EXPECT_EQ(refined.rays.targets[0].color[0], 1);
  EXPECT_EQ(refined.samples(0).size(), kRefinedSamples);
  EXPECT_EQ(refined.rays.first_sample.back(), refined.rays.samples.size());
}

TEST(RayRefinement, KeepsWhatIsSampledBeforeTheBand) {
  Refined refined;
  refined.append(0.1F, 0.01F);
  refined.add(static_cast<float>(kWall));
  refined.refine();
  ASSERT_EQ(refined.samples(0).size(), kRefinedSamples + 1);
  EXPECT_EQ(refined.samples(0)[0].depth, 0.1F);
}

TEST(RayRefinement, LeavesRaysWithoutMeasurementAlone) {
  Refined refined;
  refined.append(0.2F, 0.01F);
  refined.rays.end_ray({}); // of the layer, but without depth
  refined.append(0.3F, 0.01F);
  refined.append(0.4F, 0.01F);
  RayTarget other;
  other.foreground = false;
  refined.rays.end_ray(other);
  refined.rays.end_ray({}); // without samples
  refined.refine();
  EXPECT_EQ(refined.rays.first_sample, (std::vector<std::uint32_t>{0, 1, 3, 3}));
  EXPECT_EQ(refined.samples(1)[1].depth, 0.4F);
  EXPECT_FALSE(refined.rays.targets[1].foreground);
}

} // namespace
} // namespace kinora::fields
