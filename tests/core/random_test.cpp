#include "core/random.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

namespace kinora {
namespace {

TEST(Random, MixIsThatOfSplitMix64) {
  // First outputs of SplitMix64 with seed 0, whose state grows by the golden ratio.
  EXPECT_EQ(mix64(0), 0xE220A8397B1DCDAFULL);
  EXPECT_EQ(mix64(0x9E3779B97F4A7C15ULL), 0x6E789E6AA1B965F4ULL);
  EXPECT_EQ(mix64(2 * 0x9E3779B97F4A7C15ULL), 0x06C45D188009454FULL);
}

TEST(Random, SameKeyGivesTheSameNumbers) {
  Random a(1, 5);
  Random b(1, 5);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(a.next(), b.next());
}

TEST(Random, SeedsAndStreamsDiffer) {
  std::set<std::uint64_t> first;
  for (std::uint64_t seed = 0; seed < 32; ++seed) {
    for (std::uint64_t stream = 0; stream < 32; ++stream) first.insert(Random(seed, stream).next());
  }
  EXPECT_EQ(first.size(), 32U * 32U);
}

TEST(Random, UniformFillsTheUnitIntervalEvenly) {
  Random random(1);
  std::array<int, 20> single{};
  std::array<int, 20> both{};
  constexpr int kDraws = 200000;
  for (int i = 0; i < kDraws; ++i) {
    const float f = random.uniform();
    const double d = random.uniform_double();
    ASSERT_GE(f, 0.0F);
    ASSERT_LT(f, 1.0F);
    ASSERT_GE(d, 0.0);
    ASSERT_LT(d, 1.0);
    ++single[static_cast<std::size_t>(f * 20)];
    ++both[static_cast<std::size_t>(d * 20)];
  }
  constexpr int kMean = kDraws / 20; // binomial: standard deviation 97
  for (std::size_t bin = 0; bin < 20; ++bin) {
    EXPECT_NEAR(single[bin], kMean, 500);
    EXPECT_NEAR(both[bin], kMean, 500);
  }
}

TEST(Random, FirstNumbersOfNeighbouringStreamsAreEven) {
  std::array<int, 10> bins{};
  for (std::uint64_t stream = 0; stream < 100000; ++stream) {
    ++bins[static_cast<std::size_t>(Random(3, stream).uniform() * 10)];
  }
  for (const int bin : bins) EXPECT_NEAR(bin, 10000, 500);
}

TEST(Random, BelowStaysBelowAndReachesEveryValue) {
  Random random(2);
  EXPECT_EQ(random.below(1), 0U);
  std::array<int, 7> seen{};
  for (int i = 0; i < 7000; ++i) {
    const std::uint32_t value = random.below(7);
    ASSERT_LT(value, 7U);
    ++seen[value];
  }
  for (const int count : seen) EXPECT_NEAR(count, 1000, 150);
  for (int i = 0; i < 100; ++i) EXPECT_LT(random.below(0xFFFFFFFFU), 0xFFFFFFFFU);
}

TEST(Random, NormalHasZeroMeanAndUnitVariance) {
  Random random(4);
  double sum = 0;
  double squares = 0;
  int outside = 0;
  constexpr int kDraws = 200000;
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.normal();
    ASSERT_TRUE(std::isfinite(x));
    sum += x;
    squares += x * x;
    outside += std::abs(x) > 1.959964 ? 1 : 0;
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 0.01);
  EXPECT_NEAR(squares / kDraws, 1.0, 0.02);
  EXPECT_NEAR(outside / static_cast<double>(kDraws), 0.05, 0.003);
}

} // namespace
} // namespace kinora
