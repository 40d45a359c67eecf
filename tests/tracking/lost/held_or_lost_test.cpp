#include "tracking/lost/held_or_lost.h"

#include <gtest/gtest.h>

namespace kinora::tracking {
namespace {

TEST(HeldOrLost, HoldsForSomeFramesAndIsLostThen) {
  HeldOrLost gap(2);
  EXPECT_EQ(gap.add(motion::Health::kTracked), motion::Health::kTracked);
  EXPECT_FALSE(gap.is_open());
  EXPECT_EQ(gap.add(motion::Health::kHeld), motion::Health::kHeld);
  EXPECT_EQ(gap.add(motion::Health::kHeld), motion::Health::kHeld);
  EXPECT_EQ(gap.add(motion::Health::kHeld), motion::Health::kLost);
  EXPECT_EQ(gap.frames(), 3);
}

TEST(HeldOrLost, IsOverWithTheFirstFrameThatIsTracked) {
  HeldOrLost gap(1);
  for (int i = 0; i < 5; ++i) gap.add(motion::Health::kHeld);
  EXPECT_EQ(gap.add(motion::Health::kTracked), motion::Health::kTracked);
  EXPECT_EQ(gap.frames(), 0);
  EXPECT_EQ(gap.add(motion::Health::kHeld), motion::Health::kHeld);
}

TEST(HeldOrLost, LeavesWhatIsLostAtOnceLost) {
  EXPECT_EQ(HeldOrLost(9).add(motion::Health::kLost), motion::Health::kLost);
}

} // namespace
} // namespace kinora::tracking
