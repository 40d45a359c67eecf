#include "motion/presence.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/random.h"

namespace kinora::motion {
namespace {

TEST(Presence, IsAlwaysUnlessSpansAreGiven) {
  const Presence always;
  EXPECT_TRUE(always.is_always());
  EXPECT_TRUE(always.at(0));
  EXPECT_TRUE(always.at(1e9));
}

TEST(Presence, OfARandomRowOfFramesIsThatRow) {
  Random random(1);
  for (int round = 0; round < 200; ++round) {
    std::vector<bool> there(random.below(30));
    for (std::size_t f = 0; f < there.size(); ++f) there[f] = random.below(3) > 0;
    const Presence presence = Presence::of_frames(there);
    EXPECT_EQ(presence.in_frames(there.size()), there);
    EXPECT_EQ(Presence::away_during(presence.away()), presence);
    for (std::size_t f = 0; f < there.size(); ++f) {
      EXPECT_EQ(presence.at(static_cast<double>(f)), there[f]);
      EXPECT_EQ(presence.at(static_cast<double>(f) + 0.75), there[f]) << "a fraction counts as the frame before";
    }
  }
}

TEST(Presence, RefusesSpansThatAreEmptyTouchOrOverlap) {
  for (const std::vector<FrameSpan>& spans :
       std::vector<std::vector<FrameSpan>>{{{1, 1}}, {{2, 1}}, {{0, 2}, {2, 3}}, {{0, 3}, {2, 4}}, {{4, 5}, {0, 1}}}) {
    EXPECT_THROW((void)Presence::away_during(spans), Error);
  }
}

} // namespace
} // namespace kinora::motion
