#include "core/damped_gauss_newton.h"

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace kinora {
namespace {

// Rosenbrock's valley, whose floor is bent: residuals 1 − x and 10 (y − x²), both zero at (1, 1).
Eigen::Vector2d residuals(const Eigen::Vector2d& at) { return {1 - at.x(), 10 * (at.y() - at.x() * at.x())}; }

struct Valley {
  Eigen::Vector2d at{-1.2, 1};

  StepOutcome operator()(double damping) {
    Eigen::Matrix2d jacobian;
    jacobian << -1, 0, -20 * at.x(), 10;
    Eigen::Matrix2d information = jacobian.transpose() * jacobian;
    information.diagonal() *= 1 + damping;
    const Eigen::Vector2d gradient = jacobian.transpose() * residuals(at);
    const Eigen::Vector2d step = information.ldlt().solve(-gradient);
    const double before = residuals(at).squaredNorm();
    const double saved = before - residuals(at + step).squaredNorm();
    const double promised = before - (residuals(at) + jacobian * step).squaredNorm();
    if (!(saved > 0)) return {};
    at += step;
    return {.is_taken = true, .is_last = step.norm() < 1e-9, .gain_ratio = promised > 0 ? saved / promised : 1.0};
  }
};

template <class Damping> void expect_solved(Damping damping) {
  Valley valley;
  damped_gauss_newton(damping, 100, [&](double value) { return valley(value); });
  EXPECT_LT((valley.at - Eigen::Vector2d::Ones()).norm(), 1e-6);
}

TEST(DampedGaussNewton, FindsTheFloorOfABentValley) {
  expect_solved(MarquardtDamping({}));
  expect_solved(NielsenDamping());
}

TEST(DampedGaussNewton, DampsMoreUntilAStepPays) {
  MarquardtDamping damping({.first = 0.01, .growth = 10});
  int tried = 0;
  const auto pays_with_ten = [&](double value) {
    ++tried;
    return StepOutcome{value > 9, value > 9};
  };
  EXPECT_TRUE(damped_gauss_newton(damping, 100, pays_with_ten));
  EXPECT_EQ(tried, 4);
  EXPECT_DOUBLE_EQ(damping.value(), 2);
}

TEST(DampedGaussNewton, GivesUpAfterAllAttemptsOrWithTooMuchDamping) {
  int tried = 0;
  const auto never = [&](double) {
    ++tried;
    return StepOutcome{};
  };
  NielsenDamping nielsen;
  EXPECT_FALSE(damped_gauss_newton(nielsen, 4, never));
  EXPECT_EQ(tried, 4);
  MarquardtDamping marquardt({.first = 1, .max = 100});
  EXPECT_FALSE(damped_gauss_newton(marquardt, 100, never)); // with 1, 10 and 100
  EXPECT_EQ(tried, 7);
}

TEST(DampedGaussNewton, StopsAtTheLastStep) {
  int tried = 0;
  MarquardtDamping damping({});
  EXPECT_FALSE(damped_gauss_newton(damping, 9, [&](double) {
    ++tried;
    return StepOutcome{.is_last = true};
  }));
  EXPECT_EQ(tried, 1);
}

TEST(NielsenDamping, FallsWithGainAndRisesEverFaster) {
  NielsenDamping damping;
  damping.accept(1);
  EXPECT_DOUBLE_EQ(damping.value(), 1e-3 / 3);
  damping.accept(0.5);
  EXPECT_DOUBLE_EQ(damping.value(), 1e-3 / 3);
  damping.refuse();
  damping.refuse();
  EXPECT_DOUBLE_EQ(damping.value(), 8e-3 / 3);
}

TEST(MarquardtDamping, DampsAtLeastSoMuchAfterARefusal) {
  MarquardtDamping damping({.min_after_refusal = 0.3});
  damping.refuse();
  EXPECT_DOUBLE_EQ(damping.value(), 0.3);
  damping.refuse();
  EXPECT_DOUBLE_EQ(damping.value(), 3);
}

} // namespace
} // namespace kinora
