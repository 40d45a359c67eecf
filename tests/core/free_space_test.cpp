#include "core/free_space.h"

#include <gtest/gtest.h>

namespace kinora {
namespace {

constexpr DepthMargin kMargin{0.03, 3};

TEST(FreeSpace, MarginIsTheLargerOfBoth) {
  EXPECT_EQ(kMargin.at(1), 0.03); // three standard deviations are 6 mm there
  EXPECT_EQ(kMargin.at(4), 3 * kSensorNoise.sigma(4));
  EXPECT_GT(kMargin.at(4), 0.03);
}

TEST(FreeSpace, IsViolatedByPointsThatTheCameraSeesPast) {
  EXPECT_TRUE(violates_free_space(1, 1.031, kMargin));
  EXPECT_FALSE(violates_free_space(1, 1.029, kMargin));
  EXPECT_FALSE(violates_free_space(1, 0.9, kMargin));
}

TEST(FreeSpace, HidesPointsBehindWhatIsMeasured) {
  EXPECT_TRUE(is_occluded(1, 0.969, kMargin));
  EXPECT_FALSE(is_occluded(1, 0.971, kMargin));
  EXPECT_FALSE(is_occluded(1, 1.1, kMargin));
}

TEST(FreeSpace, WithoutAMeasurementNothingIsKnown) {
  EXPECT_FALSE(is_occluded(1, 0, kMargin));
  EXPECT_FALSE(violates_free_space(1, 0, kMargin));
}

} // namespace
} // namespace kinora
