// The vectorised training step against the scalar reference, on every instruction set of this machine.
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "fields/network/reference.h"
#include "fields/scenes/random_field.h"
#include "fields/training/adam.h"
#include "fields/training/field_optimizer.h"
#include "fields/training/loss_reference.h"
#include "support/every_instruction_set.h"

namespace kinora::fields {
namespace {

constexpr std::size_t kChunks = 3;
constexpr std::size_t kRays = 50;

RayBatch rays_of_chunk(std::size_t chunk) { return testing::random_rays(100 + chunk, kRays); }
const StepRays kGivenRays{kChunks, [](std::size_t c, RayBatch& batch) { batch = rays_of_chunk(c); }};

double relative_difference(const std::vector<float>& a, const std::vector<double>& b) {
  double largest = 0;
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, std::abs(b[i]));
    worst = std::max(worst, std::abs(a[i] - b[i]));
  }
  return worst / largest;
}

class EveryInstructionSet : public OnEveryInstructionSet {};

void expect_step_gradient_of_reference(Geometry geometry) {
  Field field = testing::random_field(5, 0.5F, geometry);
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
  const StepResult result = optimizer.gradient(kGivenRays, gradient);
  EXPECT_NEAR(result.loss, expected_loss / (kChunks * kRays), 1e-5);
  EXPECT_LT(relative_difference(gradient.table, expected.table), 2e-5);
  EXPECT_LT(relative_difference(gradient.density_net, expected.density_net), 2e-5);
  EXPECT_LT(relative_difference(gradient.color_net, expected.color_net), 2e-5);
  EXPECT_NEAR(gradient.sharpness, expected.sharpness, 2e-5 * std::abs(expected.sharpness));
}

TEST_P(EveryInstructionSet, StepGradientEqualsReference) { expect_step_gradient_of_reference(Geometry::kDensity); }

TEST_P(EveryInstructionSet, StepGradientOfSignedDistancesEqualsReference) {
  expect_step_gradient_of_reference(Geometry::kSignedDistance);
}

// Against Kingma & Ba's algorithm 1 in double. An odd number of rows from an odd row on: lines of memory and rows of
// the table do not begin together.
TEST_P(EveryInstructionSet, AdamEqualsReference) {
  constexpr std::size_t kRowsBefore = 3;
  constexpr std::size_t kCount = 91 * FieldConfig::kFeatures;
  constexpr std::size_t kBegin = kRowsBefore * FieldConfig::kFeatures;
  const kernels::AdamStep step{0.01F};
  Random random(9);
  LargeBuffer<float> p(kBegin + kCount), g(p.size()), m(p.size()), v(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    p[i] = static_cast<float>(random.normal());
    m[i] = static_cast<float>(random.normal());
    const double size = std::pow(10.0, 12 * random.uniform_double() - 8);
    v[i] = static_cast<float>(size * size);
    // Most rows have no gradient, and some elements of the others neither.
    g[i] = (i / 8) % 3 != 0 || random.below(4) == 0 ? 0.0F : static_cast<float>(size * random.normal());
  }
  const auto before = std::array{p, m, v};
  const LargeBuffer<float> gradient = g;
  kernels::adam(step, kCount, p.data() + kBegin, g.data() + kBegin, m.data() + kBegin, v.data() + kBegin);
  EXPECT_TRUE(std::all_of(g.begin() + kBegin, g.end(), [](float gradient_left) { return gradient_left == 0; }));
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (i < kBegin || gradient[i] == 0) {
      ASSERT_EQ(p[i], before[0][i]) << i;
      ASSERT_EQ(m[i], before[1][i]) << i;
      ASSERT_EQ(v[i], before[2][i]) << i;
      continue;
    }
    const double first = 0.9 * before[1][i] + 0.1 * gradient[i];
    const double second = 0.99 * before[2][i] + 0.01 * gradient[i] * gradient[i];
    const double change = 0.01 * first / (std::sqrt(second) + 1e-15);
    ASSERT_NEAR(m[i], first, 1e-6 * (std::abs(first) + 1)) << i;
    ASSERT_NEAR(v[i], second, 1e-6 * second) << i;
    ASSERT_NEAR(p[i], before[0][i] - change, 1e-5 * (std::abs(change) + std::abs(before[0][i]))) << i;
  }
}

/// kernels::quantise for one value.
double quantised(double value, double step, double up_from) {
  const double steps = std::min(std::floor(std::abs(value) / step + 1 - up_from), 32767.0);
  return std::copysign(steps * step, value);
}

TEST_P(EveryInstructionSet, AdamKeepsTheQuantisedCopy) {
  constexpr std::size_t kCount = 91 * FieldConfig::kFeatures;
  constexpr float kStep = 0.25F;
  constexpr float kUpFrom = 0.6F;
  Random random(11);
  LargeBuffer<float> p(kCount), g(kCount), m(kCount), v(kCount, 1.0F), copy(kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    p[i] = static_cast<float>(random.normal());
    g[i] = (i / 8) % 3 == 0 ? static_cast<float>(random.normal()) : 0.0F;
  }
  p[3] = 1e6F;
  const kernels::QuantisedCopy seen{{kStep, kUpFrom}, copy.data()};
  kernels::quantise(seen.quantiser, kCount, p.data(), copy.data());
  const LargeBuffer<float> before = copy;
  kernels::adam({1.0F}, kCount, p.data(), g.data(), m.data(), v.data(), &seen);
  EXPECT_NE(copy, before);
  for (std::size_t i = 0; i < kCount; ++i) ASSERT_FLOAT_EQ(copy[i], quantised(p[i], kStep, kUpFrom)) << i;
}

INSTANTIATE_TEST_SUITE_P(Sets, EveryInstructionSet, every_instruction_set(), name_of_set);

TEST(FieldOptimizer, TakesTheSameStepsOnAnyNumberOfThreads) {
  std::vector<LargeBuffer<float>> tables;
  for (const int threads : {1, 2, 7}) {
    set_thread_count(threads);
    Field field = testing::random_field(5);
    FieldOptimizer optimizer(field, {});
    const auto rays_of = [](std::size_t step) {
      return StepRays{kChunks,
                      [step](std::size_t c, RayBatch& batch) { batch = testing::random_rays(step * 10 + c, kRays); }};
    };
    optimizer.draw(rays_of(0));
    for (std::size_t step = 0; step < 5; ++step) optimizer.step({}, rays_of(step + 1));
    tables.push_back(field.table);
  }
  set_thread_count(0);
  EXPECT_EQ(tables[0], tables[1]);
  EXPECT_EQ(tables[0], tables[2]);
}

// Of steps that are much too small for any parameter to come to another multiple at once.
TEST(FieldOptimizer, MovesQuantisedTablesBySmallSteps) {
  Field field = testing::random_field(5);
  FieldOptimizer optimizer(field, {});
  const auto train = [&optimizer](int steps, float rate) {
    for (int step = 0; step < steps; ++step) optimizer.step({rate, 0}, kGivenRays);
  };
  optimizer.draw(kGivenRays);
  train(1, 0);
  const LargeBuffer<float> unrounded = field.table;
  constexpr double kUpFrom = 0.6;
  optimizer.begin_quantisation({0, 4, 0.5, kUpFrom});
  const LargeBuffer<float> begun = field.table;
  const std::vector<GridLevel> levels = grid_levels(field.config);
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const std::size_t begin = std::size_t{levels[l].offset} * FieldConfig::kFeatures;
    const std::size_t end = begin + std::size_t{levels[l].size} * FieldConfig::kFeatures;
    float step = HUGE_VALF;
    double sum = 0;
    for (std::size_t i = begin; i < end; ++i) {
      if (begun[i] != 0) step = std::min(step, std::abs(begun[i]));
      sum += static_cast<double>(unrounded[i]) * static_cast<double>(unrounded[i]);
    }
    const double steps = std::sqrt(sum / static_cast<double>(end - begin)) / static_cast<double>(step);
    const double wanted = 2 * l < levels.size() ? 4 : 0.5;
    EXPECT_GT(steps, 0.9 * wanted) << l; // of the parameters that gradients reached: nearly all
    EXPECT_LT(steps, 2.2 * wanted) << l;
    for (std::size_t i = begin; i < end; ++i) ASSERT_FLOAT_EQ(begun[i], quantised(unrounded[i], step, kUpFrom)) << i;
  }
  train(1, 1e-4F);
  const auto changed = [&] {
    std::size_t count = 0;
    for (std::size_t i = 0; i < begun.size(); ++i) count += field.table[i] != begun[i] ? 1 : 0;
    return static_cast<double>(count) / static_cast<double>(begun.size());
  };
  EXPECT_LT(changed(), 0.01);
  train(1000, 1e-4F);
  EXPECT_GT(changed(), 0.05);
}

TEST(FieldOptimizer, TakesGradientsAtQuantisedTables) {
  Field field = testing::random_field(5);
  FieldOptimizer optimizer(field, {});
  optimizer.begin_quantisation({0, 4, 4, 0.5});
  FieldOptimizer::Gradient quantised_gradient;
  optimizer.gradient(kGivenRays, quantised_gradient);
  Field rounded = field;
  FieldOptimizer::Gradient gradient;
  FieldOptimizer(rounded, {}).gradient(kGivenRays, gradient);
  EXPECT_EQ(quantised_gradient.table, gradient.table);
  EXPECT_NE(field.table, testing::random_field(5).table);
}

TEST(FieldOptimizer, LeavesOutOnlyWhatDoesNotMatter) {
  const auto gradient_without = [](float negligible) {
    Field field = testing::random_field(5);
    FieldOptimizer optimizer(field, {}, negligible);
    FieldOptimizer::Gradient gradient;
    optimizer.gradient(kGivenRays, gradient);
    return gradient;
  };
  const FieldOptimizer::Gradient all = gradient_without(0);
  const FieldOptimizer::Gradient fewest_gradients = gradient_without(5e-3F);
  const std::vector<double> exact(all.table.begin(), all.table.end());
  EXPECT_NE(all.table, fewest_gradients.table);
  EXPECT_LT(relative_difference(fewest_gradients.table, exact), 0.05);
  const FieldOptimizer::Gradient none = gradient_without(1e9F);
  EXPECT_TRUE(std::all_of(none.table.begin(), none.table.end(), [](float g) { return g == 0; }));
  EXPECT_EQ(none.color_net, all.color_net); // of rays, not of samples
}

TEST(FieldOptimizer, LeavesEverythingAsItIsWithoutRays) {
  Field field = testing::random_field(5);
  const Field before = field;
  FieldOptimizer optimizer(field, {});
  optimizer.draw({2, [](std::size_t, RayBatch&) {}});
  const StepResult result = optimizer.step({}, {});
  EXPECT_EQ(result.samples, 0U);
  EXPECT_EQ(field.table, before.table);
  EXPECT_EQ(field.color_net, before.color_net);
}

} // namespace
} // namespace kinora::fields
