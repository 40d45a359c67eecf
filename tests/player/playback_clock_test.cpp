#include "player/playback_clock.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace kinora::player {
namespace {

class Playback : public ::testing::Test {
protected:
  void wait(double seconds) { now_ += seconds; }

  double now_ = 1000; // of the master, which starts anywhere
  PlaybackClock clock_{{0, 0.1, 0.2, 0.5}, [this] { return now_; }};
};

TEST_F(Playback, StandsAtTheFirstFrameUntilItPlays) {
  wait(10);
  EXPECT_EQ(clock_.frame(), 0);
  EXPECT_FALSE(clock_.playing());
}

TEST_F(Playback, ShowsTheLastFrameWhoseTimeHasCome) {
  clock_.play();
  wait(0.099);
  EXPECT_EQ(clock_.frame(), 0);
  wait(0.001);
  EXPECT_EQ(clock_.frame(), 1) << "exactly when it is due";
  wait(0.25);
  EXPECT_EQ(clock_.frame(), 2) << "frames need not be equally long";
  EXPECT_EQ(clock_.seconds(), 0.2);
}

TEST_F(Playback, EveryFrameOfALongClipIsShownAtItsOwnTime) {
  std::vector<double> times;
  times.reserve(3000);
  for (int i = 0; i < 3000; ++i) times.push_back(i / 30.0);
  PlaybackClock clock(times, [this] { return now_; });
  clock.play();
  const double start = now_;
  for (std::size_t i = 0; i < times.size(); ++i) {
    now_ = start + times[i];
    ASSERT_EQ(clock.frame(), i);
  }
}

TEST_F(Playback, EndsWhenTheLastFrameHasBeenShownAndStartsAgain) {
  clock_.play();
  wait(0.6);
  EXPECT_EQ(clock_.frame(), 3);
  EXPECT_TRUE(clock_.playing());
  wait(10);
  EXPECT_EQ(clock_.frame(), 3);
  EXPECT_FALSE(clock_.playing());
  clock_.play();
  EXPECT_EQ(clock_.frame(), 0);
  EXPECT_TRUE(clock_.playing());
}

TEST_F(Playback, RepeatsWhenAskedTo) {
  clock_.set_loop(true);
  clock_.play();
  const double period = 0.5 + 0.5 / 3;
  wait(5 * period + 0.15);
  EXPECT_EQ(clock_.frame(), 1);
  EXPECT_TRUE(clock_.playing());
}

TEST_F(Playback, SpeedCountsFromWhereItWasChanged) {
  clock_.play();
  wait(0.05);
  clock_.set_speed(0.5);
  wait(0.08);
  EXPECT_EQ(clock_.frame(), 0);
  wait(0.03);
  EXPECT_EQ(clock_.frame(), 1);
  EXPECT_THROW(clock_.set_speed(0), Error);
  EXPECT_THROW(clock_.set_speed(17), Error);
}

TEST_F(Playback, SeeksInsideTheClipAndPlaysOn) {
  clock_.play();
  clock_.seek(0.19);
  EXPECT_EQ(clock_.frame(), 1);
  wait(0.02);
  EXPECT_EQ(clock_.frame(), 2);
  clock_.seek(-4);
  EXPECT_EQ(clock_.frame(), 0);
  clock_.seek(77);
  EXPECT_EQ(clock_.frame(), 3);
}

TEST_F(Playback, StepsPauseAndStayInsideTheClip) {
  clock_.play();
  wait(0.1);
  clock_.step(1);
  EXPECT_EQ(clock_.frame(), 2);
  wait(5);
  EXPECT_EQ(clock_.frame(), 2) << "it is paused";
  clock_.step(-9);
  EXPECT_EQ(clock_.frame(), 0);
  clock_.step(9);
  EXPECT_EQ(clock_.frame(), 3);
}

TEST_F(Playback, GoesOnFromTheFrameWhereItWasPaused) {
  clock_.play();
  wait(0.11);
  clock_.pause();
  wait(3);
  EXPECT_EQ(clock_.frame(), 1);
  clock_.play();
  wait(0.09);
  EXPECT_EQ(clock_.frame(), 1);
  wait(0.02);
  EXPECT_EQ(clock_.frame(), 2);
}

TEST_F(Playback, FollowsTheSoundAndWaitsWhenItStalls) {
  double heard = 7;
  clock_.play();
  wait(0.1);
  clock_.set_master([&heard] { return heard; });
  wait(100);
  EXPECT_EQ(clock_.frame(), 1) << "nothing was heard";
  heard += 0.1;
  EXPECT_EQ(clock_.frame(), 2);
}

TEST_F(Playback, WaitsAtTheEndOfWhatHasComeAndGoesOn) {
  std::vector<double> some = {0, 0.1, 0.2};
  clock_.set_times(some, true);
  clock_.set_loop(true);
  clock_.play();
  wait(1000);
  EXPECT_EQ(clock_.frame(), 2);
  EXPECT_TRUE(clock_.playing());
  some.insert(some.end(), {0.3, 0.4});
  clock_.set_times(some, true);
  EXPECT_EQ(clock_.frame(), 3) << "the time that it waited is caught up with";
  wait(0.1);
  EXPECT_EQ(clock_.frame(), 4);
  clock_.set_times(some, false);
  clock_.set_loop(false);
  wait(1);
  EXPECT_FALSE(clock_.playing());
}

TEST_F(Playback, WaitsBeforeWhatHasNotComeWhereverItStands) {
  const std::vector<double> times = {0, 0.1, 0.2, 0.3, 0.4};
  clock_.set_times(times, true, {true, true, false, true, true});
  clock_.play();
  wait(0.15);
  EXPECT_FALSE(clock_.starved());
  wait(10);
  EXPECT_EQ(clock_.frame(), 1);
  EXPECT_TRUE(clock_.starved());
  EXPECT_TRUE(clock_.playing());
  clock_.seek(0.2); // nothing of it is there
  EXPECT_EQ(clock_.frame(), 2);
  EXPECT_FALSE(clock_.is_there(clock_.frame()));
  wait(10);
  EXPECT_EQ(clock_.frame(), 2);
  clock_.seek(0.3); // behind the gap
  wait(0.1);
  EXPECT_EQ(clock_.frame(), 4);
  clock_.seek(0.1);
  wait(10);
  clock_.set_times(times, true, {true, true, true, true, true});
  EXPECT_FALSE(clock_.starved());
  wait(0.11);
  EXPECT_EQ(clock_.frame(), 3) << "it goes on from where it waited";
  clock_.set_times(times, false);
  EXPECT_TRUE(clock_.is_there(2));
}

} // namespace
} // namespace kinora::player
