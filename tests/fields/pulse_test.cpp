// A training that learns nothing more is noticed, though every number is finite.
#include <gtest/gtest.h>

#include <limits>

#include "fields/pulse.h"

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
std::optional<Fault> fault_after(Pulse pulse, const StepResult& step, int count) {
  for (int i = 1; i < count; ++i) pulse.fault(step);
  return pulse.fault(step);
}

/// Has seen a good training so far.
Pulse healthy_pulse() {
  Pulse pulse;
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(pulse.fault(healthy_step()), std::nullopt) << "step " << i;
  return pulse;
}

TEST(Pulse, NoticesNumbersThatAreNotFiniteAtOnce) {
  StepResult step = healthy_step();
  for (const double loss : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    step.loss = loss;
    EXPECT_EQ(Pulse().fault(step), Fault::kNotFinite);
  }
}

TEST(Pulse, NoticesAFieldThatIsOpaqueNowhere) {
  StepResult step = healthy_step();
  step.opacity = 0;
  EXPECT_EQ(healthy_pulse().fault(step), Fault::kTransparent);
  EXPECT_EQ(fault_after({}, step, 300), Fault::kTransparent);
}

TEST(Pulse, NoticesAFieldThatIsOneColorEverywhere) {
  StepResult step = healthy_step();
  step.color_error = step.color_variance; // as for the best one: a wrong one, as black, is worse
  for (const double worse : {1.0, 3.0}) {
    step.color_error *= worse;
    EXPECT_EQ(fault_after(healthy_pulse(), step, 300), Fault::kOneColor);
    EXPECT_EQ(fault_after({}, step, 300), Fault::kOneColor);
  }
}

TEST(Pulse, ForgivesAFewStepsOfOneColor) {
  StepResult step = healthy_step();
  step.color_error = step.color_variance;
  EXPECT_EQ(fault_after(healthy_pulse(), step, 5), std::nullopt);
}

TEST(Pulse, ExpectsNothingOfTheFirstSteps) {
  StepResult step = healthy_step();
  step.opacity = 0;
  step.color_error = step.color_variance;
  EXPECT_EQ(fault_after({}, step, 200), std::nullopt);
}

TEST(Pulse, LetsAnEvenlyColoredLayerBeOfOneColor) {
  StepResult step = healthy_step();
  step.color_error = step.color_variance = 1e-3; // noise
  EXPECT_EQ(fault_after({}, step, 1000), std::nullopt);
}

} // namespace
} // namespace kinora::fields
