#include "tracking/rigid/tracking_gap.h"

#include <gtest/gtest.h>

namespace kinora::tracking {
namespace {

TEST(TrackingGap, HoldsForSomeFramesAndIsLostThen) {
  TrackingGap gap(2);
  EXPECT_EQ(gap.add(motion::Health::kTracked), motion::Health::kTracked);
  EXPECT_FALSE(gap.is_open());
  EXPECT_EQ(gap.add(motion::Health::kHeld), motion::Health::kHeld);
  EXPECT_EQ(gap.add(motion::Health::kHeld), motion::Health::kHeld);
  EXPECT_EQ(gap.add(motion::Health::kHeld), motion::Health::kLost);
  EXPECT_EQ(gap.frames(), 3);
}

TEST(TrackingGap, IsOverWithTheFirstFrameThatIsTracked) {
  TrackingGap gap(1);
  for (int i = 0; i < 5; ++i) gap.add(motion::Health::kHeld);
  EXPECT_EQ(gap.add(motion::Health::kTracked), motion::Health::kTracked);
  EXPECT_EQ(gap.frames(), 0);
  EXPECT_EQ(gap.add(motion::Health::kHeld), motion::Health::kHeld);
}

TEST(TrackingGap, LeavesWhatIsLostAtOnceLost) {
  EXPECT_EQ(TrackingGap(9).add(motion::Health::kLost), motion::Health::kLost);
}

} // namespace
} // namespace kinora::tracking
