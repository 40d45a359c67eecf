// A training that learns nothing more is noticed, though every number is finite.
#include <gtest/gtest.h>

#include <limits>

#include "fields/training/collapse.h"

namespace kinora::fields {
namespace {

/// Of a field that learns: opaque, and most of the colours' variance is explained.
StepResult healthy_step() {
  StepResult step;
  step.loss = 0.05;
  step.opacity = 0.9;
  step.color_error = 0.02;
  step.color_variance = 0.1;
  return step;
}

/// What is said of the last of `count` such steps.
std::optional<Collapse> collapse_after(CollapseDetector detector, const StepResult& step, int count) {
  for (int i = 1; i < count; ++i) detector.collapse(step);
  return detector.collapse(step);
}

/// Has seen a good training so far.
CollapseDetector healthy() {
  CollapseDetector detector;
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(detector.collapse(healthy_step()), std::nullopt) << "step " << i;
  return detector;
}

TEST(CollapseDetector, NoticesNumbersThatAreNotFiniteAtOnce) {
  StepResult step = healthy_step();
  for (const double loss : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    step.loss = loss;
    EXPECT_EQ(CollapseDetector().collapse(step), Collapse::kNotFinite);
  }
}

TEST(CollapseDetector, NoticesAFieldThatIsOpaqueNowhere) {
  StepResult step = healthy_step();
  step.opacity = 0;
  EXPECT_EQ(healthy().collapse(step), Collapse::kTransparent);
  EXPECT_EQ(collapse_after({}, step, 300), Collapse::kTransparent);
}

TEST(CollapseDetector, NoticesAFieldThatIsOneColorEverywhere) {
  StepResult step = healthy_step();
  step.color_error = step.color_variance; // as for the best one: a wrong one, as black, is worse
  for (const double worse : {1.0, 3.0}) {
    step.color_error *= worse;
    EXPECT_EQ(collapse_after(healthy(), step, 300), Collapse::kOneColor);
    EXPECT_EQ(collapse_after({}, step, 300), Collapse::kOneColor);
  }
}

TEST(CollapseDetector, ForgivesAFewStepsOfOneColor) {
  StepResult step = healthy_step();
  step.color_error = step.color_variance;
  EXPECT_EQ(collapse_after(healthy(), step, 5), std::nullopt);
}

TEST(CollapseDetector, ExpectsNothingOfTheFirstSteps) {
  StepResult step = healthy_step();
  step.opacity = 0;
  step.color_error = step.color_variance;
  EXPECT_EQ(collapse_after({}, step, 200), std::nullopt);
}

TEST(CollapseDetector, LetsAnEvenlyColoredLayerBeOfOneColor) {
  StepResult step = healthy_step();
  step.color_error = step.color_variance = 1e-3; // noise
  EXPECT_EQ(collapse_after({}, step, 1000), std::nullopt);
}

} // namespace
} // namespace kinora::fields
