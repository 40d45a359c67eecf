#include "clip/coding/level_quantiser.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/random.h"

namespace kinora::clip {
namespace {

std::vector<float> gaussian(std::uint64_t seed, std::size_t count, double scale) {
  Random random(seed);
  std::vector<float> values(count);
  for (float& v : values) v = static_cast<float>(random.normal() * scale);
  return values;
}

constexpr int kSteps = 16;

QuantisedLevel quantise_16(std::span<const float> values) { return quantise(values, {kSteps}); }

std::vector<float> dequantised(const QuantisedLevel& level) {
  std::vector<float> values;
  for (const std::int16_t v : level.values) values.push_back(dequantise(v, level.exponent));
  return values;
}

double rms(const std::vector<float>& values) {
  double sum = 0;
  for (const float v : values) sum += static_cast<double>(v) * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

TEST(LevelQuantiser, StaysWithinHalfAStepOfValuesOfAnyScale) {
  for (const double scale : {1e-9, 1e-4, 0.1, 1.0, 300.0, 1e6}) {
    const std::vector<float> values = gaussian(1, 2000, scale);
    const std::vector<float> back = dequantised(quantise_16(values));
    const double bound = rms(values) / (2 * kSteps) * (1 + 1e-6);
    for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(back[i], values[i], bound) << scale;
  }
}

// Half as fine costs quality, twice as fine a bit of every parameter: either is a decision (docs/container.md).
TEST(LevelQuantiser, HasBetweenSixteenAndThirtyTwoStepsInTheRootMeanSquare) {
  for (const double scale : {0.001, 0.1, 0.13, 0.19, 1.0, 50.0}) {
    const std::vector<float> values = gaussian(4, 3000, scale);
    const double steps = rms(values) / std::ldexp(1.0, quantise_16(values).exponent);
    EXPECT_GE(steps, 16) << scale;
    EXPECT_LT(steps, 32) << scale;
  }
}

TEST(LevelQuantiser, KeepsOutliersWithoutCoarseningTheRest) {
  std::vector<float> values = gaussian(2, 5000, 0.1);
  values[77] = 30;
  const std::vector<float> back = dequantised(quantise_16(values));
  const double bound = rms(values) / (2 * kSteps) * (1 + 1e-6);
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(back[i], values[i], bound) << i;
}

TEST(LevelQuantiser, FitsAnOutlierOfAnySize) {
  std::vector<float> values = gaussian(3, 100'000, 1e-6);
  values[5] = -1000;
  const std::vector<float> back = dequantised(quantise_16(values));
  EXPECT_NEAR(back[5], -1000, 0.1);
}

TEST(LevelQuantiser, LeavesQuantisedValuesAsTheyAre) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Random random(seed, 9);
    const std::size_t count = 1 + random.below(60);
    std::vector<float> values = gaussian(seed, count, std::exp(random.normal() * 5));
    if (random.below(3) == 0) values[random.below(static_cast<std::uint32_t>(count))] *= 3000;
    if (random.below(3) == 0) values[0] = 0;
    const QuantisedLevel first = quantise_16(values);
    const QuantisedLevel second = quantise_16(dequantised(first));
    EXPECT_EQ(first.exponent, second.exponent) << seed;
    EXPECT_EQ(first.values, second.values) << seed;
  }
}

TEST(LevelQuantiser, LeavesAnyMultiplesOf16BitsUnlessAnew) {
  const std::vector<float> values = dequantised(quantise(gaussian(5, 3000, 0.2), {200}));
  EXPECT_EQ(dequantised(quantise(values, {0.5})), values);
  const QuantisedLevel anew = quantise(values, {0.5, 0.5, true});
  EXPECT_NE(dequantised(anew), values);
  EXPECT_LE(rms(values) / std::ldexp(1.0, anew.exponent), 1);
}

TEST(LevelQuantiser, KeepsZerosAndNothingAtAll) {
  EXPECT_EQ(dequantised(quantise_16(std::vector<float>(10))), std::vector<float>(10));
  EXPECT_TRUE(quantise_16({}).values.empty());
}

TEST(LevelQuantiser, KeepsTheLargestAndForgetsTheSmallestFloats) {
  const std::vector<float> large{std::ldexp(1.0F, 54), -std::ldexp(1.0F, 53)};
  EXPECT_EQ(dequantised(quantise_16(large)), large);
  EXPECT_EQ(dequantised(quantise_16(std::vector<float>{1e-40F, -1e-44F})), (std::vector<float>{0, 0}));
}

TEST(LevelQuantiser, RefusesWhatIsNotFinite) {
  for (const float bad : {std::nanf(""), INFINITY, -INFINITY, 1e30F}) {
    EXPECT_THROW(quantise_16(std::vector<float>{1, bad}), Error) << bad;
  }
}

} // namespace
} // namespace kinora::clip
