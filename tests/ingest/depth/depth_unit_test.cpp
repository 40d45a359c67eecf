#include "ingest/depth/depth_unit.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace kinora::ingest {
namespace {

/// A room, a fifth of which is not measured.
DepthImage room(float scale) {
  DepthImage depth(40, 30);
  Random random(3);
  for (float& z : depth.values()) z = random.below(5) == 0 ? 0 : scale * (1 + 3 * random.uniform());
  return depth;
}

TEST(DepthUnit, IsNotDoubtedInARoom) {
  EXPECT_EQ(depth_unit_warning(room(1)), "");
  EXPECT_EQ(depth_unit_warning(room(0.25F)), "");
  EXPECT_EQ(depth_unit_warning(room(4)), "");
}

TEST(DepthUnit, IsDoubtedWhereTheRoomWouldBeTooSmallOrTooLarge) {
  EXPECT_NE(depth_unit_warning(room(0.1F)).find("nearer than"), std::string::npos);
  EXPECT_NE(depth_unit_warning(room(0.001F)).find("depth_factor"), std::string::npos);
  EXPECT_NE(depth_unit_warning(room(10)).find("beyond"), std::string::npos);
}

TEST(DepthUnit, IsNotDoubtedWithoutMeasurements) {
  EXPECT_EQ(depth_unit_warning(DepthImage(4, 4)), "");
  EXPECT_EQ(depth_unit_warning(DepthImage()), "");
}

} // namespace
} // namespace kinora::ingest
