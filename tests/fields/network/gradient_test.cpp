// The reference's gradients against central differences, in double, for every kind of parameter.
#include <gtest/gtest.h>

#include "fields/network/reference.h"
#include "fields/scenes/random_field.h"
#include "fields/training/loss_reference.h"

namespace kinora::fields {
namespace {

using reference::Parameters;

constexpr Geometry kGeometries[] = {Geometry::kDensity, Geometry::kSignedDistance};

struct RandomRays {
  Geometry geometry = Geometry::kDensity;
  Field field = testing::random_field(7, 0.5F, geometry);
  std::vector<GridLevel> levels = grid_levels(field.config);
  RayBatch rays = testing::random_rays(11, 24);
  LossWeights weights{1.0F, 0.4F, 0.3F, 0.6F, 4.0F};
  Parameters<double> parameters{field};

  double loss(const Parameters<double>& p, Parameters<double>* gradient) const {
    double sum = 0;
    for (std::size_t r = 0; r < rays.ray_count(); ++r) {
      const std::span<const RaySample> samples(rays.samples.data() + rays.first_sample[r],
                                               rays.samples.data() + rays.first_sample[r + 1]);
      sum += reference::ray_loss<double>(field.config, levels, p, samples, rays.targets[r], weights, 1.0, gradient);
    }
    return sum;
  }

  // Largest difference between analytic and numeric derivatives, relative to the largest derivative of the kind.
  double worst_error(std::vector<double> Parameters<double>::*kind, std::size_t probes) {
    Parameters<double> gradient = parameters.zeros();
    loss(parameters, &gradient);
    const std::vector<double>& analytic = gradient.*kind;
    double largest = 0;
    for (const double g : analytic) largest = std::max(largest, std::abs(g));
    EXPECT_GT(largest, 0);
    Random random(3);
    double worst = 0;
    for (std::size_t k = 0; k < probes; ++k) {
      // Half of the probes where something is to be seen, half anywhere.
      std::size_t i = random.below(static_cast<std::uint32_t>(analytic.size()));
      while (k % 2 == 0 && std::abs(analytic[i]) < 1e-3 * largest) {
        i = random.below(static_cast<std::uint32_t>(analytic.size()));
      }
      constexpr double kStep = 1e-6;
      Parameters<double> moved = parameters;
      (moved.*kind)[i] += kStep;
      const double up = loss(moved, nullptr);
      (moved.*kind)[i] -= 2 * kStep;
      const double numeric = (up - loss(moved, nullptr)) / (2 * kStep);
      worst = std::max(worst, std::abs(numeric - analytic[i]) / largest);
    }
    return worst;
  }
};

TEST(ReferenceGradient, OfHashTableMatchesDifferences) {
  for (const Geometry geometry : kGeometries) {
    EXPECT_LT(RandomRays{geometry}.worst_error(&Parameters<double>::table, 120), 1e-6);
  }
}

TEST(ReferenceGradient, OfDensityNetMatchesDifferences) {
  for (const Geometry geometry : kGeometries) {
    EXPECT_LT(RandomRays{geometry}.worst_error(&Parameters<double>::density_net, 120), 1e-6);
  }
}

TEST(ReferenceGradient, OfColorNetMatchesDifferences) {
  for (const Geometry geometry : kGeometries) {
    EXPECT_LT(RandomRays{geometry}.worst_error(&Parameters<double>::color_net, 120), 1e-6);
  }
}

TEST(ReferenceGradient, OfSharpnessMatchesDifferences) {
  const RandomRays given{Geometry::kSignedDistance};
  Parameters<double> gradient = given.parameters.zeros();
  given.loss(given.parameters, &gradient);
  constexpr double kStep = 1e-6;
  Parameters<double> up = given.parameters;
  Parameters<double> down = given.parameters;
  up.sharpness += kStep;
  down.sharpness -= kStep;
  EXPECT_GT(std::abs(gradient.sharpness), 1e-3);
  EXPECT_NEAR((given.loss(up, nullptr) - given.loss(down, nullptr)) / (2 * kStep), gradient.sharpness, 1e-6);
}

TEST(ReferenceGradient, OfEveryLossTermAloneMatchesDifferences) {
  for (int term = 0; term < 5; ++term) {
    RandomRays given{Geometry::kSignedDistance};
    given.weights = {
        term == 0 ? 1.0F : 0.0F, term == 1 ? 1.0F : 0.0F, term == 2 ? 1.0F : 0.0F, term == 3 ? 1.0F : 0.0F, 4.0F,
        term == 4 ? 1.0F : 0.0F};
    EXPECT_LT(given.worst_error(&Parameters<double>::table, 40), 1e-6) << "term " << term;
  }
}

TEST(Reference, RayWithoutSamplesIsTransparentAndHasNoGradient) {
  RandomRays given;
  Parameters<double> gradient = given.parameters.zeros();
  RayTarget target;
  target.foreground = false;
  EXPECT_EQ(reference::ray_loss<double>(given.field.config, given.levels, given.parameters, {}, target, given.weights,
                                        1.0, &gradient),
            0.0);
  for (const double g : gradient.table) ASSERT_EQ(g, 0.0);
}

} // namespace
} // namespace kinora::fields
