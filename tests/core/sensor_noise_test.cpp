#include "core/sensor_noise.h"

#include <cmath>

#include <gtest/gtest.h>

namespace kinora {
namespace {

TEST(SensorNoise, IsThatOfThePaper) {
  EXPECT_DOUBLE_EQ(kSensorNoise.sigma(0.4), 0.0012);
  EXPECT_DOUBLE_EQ(kSensorNoise.sigma(1.4), 0.0031);
  EXPECT_DOUBLE_EQ(kSensorNoise.sigma(2.4), 0.0088);
}

TEST(SensorNoise, GrowsWithItsScale) {
  const SensorNoise noise{2.5F};
  for (const double z : {0.5, 1.0, 3.0}) {
    const auto depth = static_cast<float>(z);
    EXPECT_DOUBLE_EQ(noise.sigma(z), 2.5 * kSensorNoise.sigma(z));
    EXPECT_FLOAT_EQ(noise.three_sigma(depth), 2.5F * kSensorNoise.three_sigma(depth));
    EXPECT_FLOAT_EQ(noise.three_sigma(depth), static_cast<float>(3 * noise.sigma(z)));
  }
}

TEST(SensorNoise, AcrossASurfaceIsLessTheFlatterItIsSeen) {
  EXPECT_EQ(kSensorNoise.sigma_across(2, 1), kSensorNoise.sigma(2));
  EXPECT_EQ(kSensorNoise.sigma_across(2, 0.5), 0.5 * kSensorNoise.sigma(2));
  EXPECT_EQ(kSensorNoise.sigma_across(2, 0), kSensorNoise.sigma_across(2, SensorNoise::kMinCosine));
}

TEST(SensorNoise, OfADifferenceIsThatOfTwoMeasurements) {
  EXPECT_NEAR(kThreeSigmaOfDifference, 3 * std::sqrt(2.0), 0.01);
}

} // namespace
} // namespace kinora
