// The vectorised training step against the scalar reference, on every instruction set of this machine.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "core/parallel.h"
#include "fields/kernels.h"
#include "fields/optimizer.h"
#include "fields/reference.h"
#include "random_field.h"

namespace kinora::fields {
namespace {

constexpr std::size_t kChunks = 3;
constexpr std::size_t kRays = 50;

RayBatch rays_of_chunk(std::size_t chunk) { return testing::random_rays(100 + chunk, kRays); }

double relative_difference(const std::vector<float>& a, const std::vector<double>& b) {
  double largest = 0;
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, std::abs(b[i]));
    worst = std::max(worst, std::abs(a[i] - b[i]));
  }
  return worst / largest;
}

class EveryInstructionSet : public ::testing::TestWithParam<std::int64_t> {
protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

TEST_P(EveryInstructionSet, StepGradientEqualsReference) {
  Field field = testing::random_field(5);
  const std::vector<GridLevel> levels = grid_levels(field.config);
  const LossWeights weights{1.0F, 0.4F, 0.3F, 0.6F, 4.0F};

  const reference::Parameters<double> parameters(field);
  reference::Parameters<double> expected = parameters.zeros();
  double expected_loss = 0;
  for (std::size_t c = 0; c < kChunks; ++c) {
    const RayBatch rays = rays_of_chunk(c);
    for (std::size_t r = 0; r < kRays; ++r) {
      const std::span<const RaySample> samples(rays.samples.data() + rays.first_sample[r],
                                               rays.samples.data() + rays.first_sample[r + 1]);
      expected_loss += reference::ray_loss<double>(field.config, levels, parameters, samples, rays.targets[r], weights,
                                                   1.0 / (kChunks * kRays), &expected);
    }
  }

  FieldOptimizer optimizer(field, weights);
  FieldOptimizer::Gradient gradient;
  const StepResult result = optimizer.gradient(
      kChunks, [](std::size_t c, RayBatch& batch) { batch = rays_of_chunk(c); }, gradient);
  EXPECT_NEAR(result.loss, expected_loss / (kChunks * kRays), 1e-5);
  EXPECT_LT(relative_difference(gradient.table, expected.table), 2e-5);
  EXPECT_LT(relative_difference(gradient.density_net, expected.density_net), 2e-5);
  EXPECT_LT(relative_difference(gradient.color_net, expected.color_net), 2e-5);
}

INSTANTIATE_TEST_SUITE_P(Kernels, EveryInstructionSet, ::testing::ValuesIn(hwy::SupportedAndGeneratedTargets()),
                         [](const auto& target) { return std::string(hwy::TargetName(target.param)); });

TEST(FieldOptimizer, TakesTheSameStepsOnAnyNumberOfThreads) {
  std::vector<LargeBuffer<float>> tables;
  for (const int threads : {1, 2, 7}) {
    set_thread_count(threads);
    Field field = testing::random_field(5);
    FieldOptimizer optimizer(field, {});
    for (int step = 0; step < 5; ++step) {
      optimizer.step(kChunks,
                     [step](std::size_t c, RayBatch& batch) {
                       batch = testing::random_rays(static_cast<std::uint64_t>(step) * 10 + c, kRays);
                     },
                     {});
    }
    tables.push_back(field.table);
  }
  set_thread_count(0);
  EXPECT_EQ(tables[0], tables[1]);
  EXPECT_EQ(tables[0], tables[2]);
}

TEST(FieldOptimizer, LeavesOutOnlyWhatDoesNotMatter) {
  const auto gradient_without = [](float negligible) {
    Field field = testing::random_field(5);
    FieldOptimizer optimizer(field, {}, negligible);
    FieldOptimizer::Gradient gradient;
    optimizer.gradient(
        kChunks, [](std::size_t c, RayBatch& batch) { batch = rays_of_chunk(c); }, gradient);
    return gradient;
  };
  const FieldOptimizer::Gradient all = gradient_without(0);
  const FieldOptimizer::Gradient most = gradient_without(5e-3F);
  const std::vector<double> exact(all.table.begin(), all.table.end());
  EXPECT_NE(all.table, most.table);
  EXPECT_LT(relative_difference(most.table, exact), 0.05);
  const FieldOptimizer::Gradient none = gradient_without(1e9F);
  EXPECT_TRUE(std::all_of(none.table.begin(), none.table.end(), [](float g) { return g == 0; }));
  EXPECT_EQ(none.color_net, all.color_net); // of rays, not of samples
}

TEST(FieldOptimizer, LeavesEverythingAsItIsWithoutRays) {
  Field field = testing::random_field(5);
  const Field before = field;
  FieldOptimizer optimizer(field, {});
  const StepResult result = optimizer.step(2, [](std::size_t, RayBatch&) {}, {});
  EXPECT_EQ(result.samples, 0U);
  EXPECT_EQ(field.table, before.table);
  EXPECT_EQ(field.color_net, before.color_net);
}

TEST(FieldOptimizer, StaysFiniteWithRawDensitiesOfTenThousand) {
  for (const float sign : {1.0F, -1.0F}) {
    Field field = testing::random_field(5, 0.0F);
    for (float& v : field.table) v = 100;
    std::fill(field.density_net.begin(), field.density_net.end(), 0.0F);
    const std::size_t width = field.density_net.size() / FieldConfig::kHidden - FieldConfig::kGeometry;
    for (std::size_t i = 0; i < width; ++i) field.density_net[i * FieldConfig::kHidden] = 1;
    field.density_net[width * FieldConfig::kHidden] = sign * 10'000.0F / (100.0F * static_cast<float>(width));
    FieldOptimizer optimizer(field, {});
    for (int step = 0; step < 3; ++step) {
      optimizer.step(kChunks, [](std::size_t c, RayBatch& batch) { batch = rays_of_chunk(c); }, {});
    }
    for (const float v : field.table) ASSERT_TRUE(std::isfinite(v));
    for (const float v : field.density_net) ASSERT_TRUE(std::isfinite(v));
  }
}

} // namespace
} // namespace kinora::fields
