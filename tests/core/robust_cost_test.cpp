#include "core/robust_cost.h"

#include <gtest/gtest.h>

namespace kinora {
namespace {

constexpr double kStep = 1e-6;

/// `gradient`: of the cost, which weight · r must be.
template <class Cost, class Weight> void expect_weight_is_slope(const Cost& cost, const Weight& weight) {
  for (const double r : {-4.0, -1.2, -0.3, 0.2, 1.0, 3.0}) {
    EXPECT_NEAR(weight(r) * r, (cost(r + kStep) - cost(r - kStep)) / (2 * kStep), 1e-6) << r;
  }
}

TEST(Huber, IsQuadraticThenLinear) {
  const Huber huber{1.5};
  EXPECT_EQ(huber.cost(-1), 0.5);
  EXPECT_EQ(huber.weight(-1), 1);
  EXPECT_DOUBLE_EQ(huber.cost(11.5) - huber.cost(10.5), 1.5);
  EXPECT_EQ(huber.weight(-3), 0.5);
}

TEST(Huber, WeighsResidualsByTheSlopeOfTheCost) {
  const Huber huber{1.5};
  expect_weight_is_slope([&](double r) { return huber.cost(r); }, [&](double r) { return huber.weight(r); });
}

TEST(TruncatedHuber, CostsNoMoreFromTwoAndAHalfThresholdsOn) {
  const TruncatedHuber huber{2};
  EXPECT_EQ(huber.cost(1), Huber{2}.cost(1));
  EXPECT_LT(huber.cost(4.9), huber.max_cost());
  EXPECT_EQ(huber.cost(5), huber.max_cost());
  EXPECT_EQ(huber.cost(100), huber.max_cost());
  EXPECT_EQ(huber.weight(100), Huber{2}.weight(100)) << "what is far off still draws";
}

TEST(GemanMcClure, IsSquareForSmallResidualsAndBounded) {
  const GemanMcClure cost{0.02, 0.06};
  EXPECT_NEAR(cost.cost(1e-8), 1e-8 / 4e-4, 1e-9);
  EXPECT_NEAR(cost.cost(0.06 * 0.06), 4.5, 1e-9) << "half of the most, at the cutoff";
  EXPECT_LT(cost.cost(1e6), 9.0001);
}

TEST(GemanMcClure, WeighsResidualsByTheSlopeOfTheCost) {
  const GemanMcClure cost{1, 2};
  expect_weight_is_slope([&](double r) { return 0.5 * cost.cost(r * r); },
                         [&](double r) { return cost.weight(r * r); });
}

} // namespace
} // namespace kinora
