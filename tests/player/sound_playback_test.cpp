// Claims about hearing a clip's sound while its pictures are seen.
#include "player/window/sound_playback.h"

#include <cmath>

#include <gtest/gtest.h>

#include "container/little_endian.h"
#include "core/error.h"

namespace kinora::player::window {
namespace {

constexpr double kRate = sound::kPlayedRate;
constexpr double kSecondsOfSound = 3;
constexpr double kTogether = 0.04; // seconds that sound and picture may be apart

/// Sound whose every sample says when it is to be heard: seconds / 4, in packets of 20 ms, from `begin` on.
std::shared_ptr<const container::Sound> telling_sound(double begin = 0) {
  constexpr int kPacketSamples = sound::kPlayedRate / 50;
  auto sound = std::make_shared<container::Sound>();
  sound->track.codec = "A_PCM/FLOAT/IEEE";
  sound->track.media = container::MediaFormat{};
  sound->track.media->sampling_rate = sound::kPlayedRate;
  sound->track.media->channels = 1;
  sound->track.media->bits = 32;
  for (double at = begin; at < kSecondsOfSound - 1e-9; at += kPacketSamples / kRate) {
    container::Payload packet{container::kSoundTrack, std::llround(at * 1e9), true, {}};
    for (int i = 0; i < kPacketSamples; ++i) {
      const auto value = static_cast<float>((at + i / kRate) / 4);
      std::uint32_t bits = 0;
      std::memcpy(&bits, &value, sizeof bits);
      container::put(packet.bytes, bits);
    }
    sound->packets.push_back(std::move(packet));
  }
  return sound;
}

/// A device that takes 512 samples at once, and from then on is heard playing them.
struct Device {
  double now = 0;
  std::vector<float> waiting; ///< of one side
  std::vector<float> in_hand; ///< taken, and heard from `begun` on
  double begun = 0;
  bool broken = false;
  int opened = 0;

  void pass(double seconds) {
    constexpr double kTaken = Loudspeaker::kTakenAtOnce / kRate;
    now += seconds;
    while (!broken && now - begun >= kTaken) {
      begun += kTaken;
      const auto taken = std::min<std::size_t>(Loudspeaker::kTakenAtOnce, waiting.size());
      in_hand = pending;
      pending.assign(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(taken));
      waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(taken));
    }
  }
  float heard() const {
    const auto i = static_cast<std::size_t>((now - begun) * kRate);
    return i < in_hand.size() ? in_hand[i] : 0;
  }

  std::vector<float> pending; ///< taken, to be heard after `in_hand`
};

class FakeLoudspeaker final : public Loudspeaker {
public:
  explicit FakeLoudspeaker(Device& device) : device_(device) { ++device.opened; }
  void play(std::span<const float> samples) override {
    for (std::size_t i = 0; i < samples.size(); i += 2) {
      EXPECT_EQ(samples[i], samples[i + 1]); // one channel, on both sides
      device_.waiting.push_back(samples[i]);
    }
  }
  std::size_t waiting() const override { return device_.waiting.size(); }
  void stop() override { device_.waiting.clear(); }

private:
  Device& device_;
};

class SoundPlaybackTest : public ::testing::Test {
protected:
  SoundPlaybackTest() {
    std::vector<double> times(90);
    for (std::size_t i = 0; i < times.size(); ++i) times[i] = static_cast<double>(i) / 30;
    clock_.emplace(std::move(times), seconds());
    playback_.set_sound(telling_sound());
  }

  MasterClock seconds() {
    return [this] { return device_.now; };
  }
  /// As a window does: ninety times a second. Calls `look` for each.
  template <class Look> void pass(double seconds, const Look& look) {
    for (double gone = 0; gone < seconds; gone += 1.0 / 90) {
      device_.pass(1.0 / 90);
      playback_.follow(*clock_);
      look();
    }
  }
  void pass(double seconds) {
    pass(seconds, [] {});
  }
  void expect_together(double seconds) {
    pass(seconds, [this] { EXPECT_NEAR(4 * device_.heard(), clock_->position(), kTogether); });
  }
  void expect_silence(double seconds) {
    pass(seconds, [this] { EXPECT_EQ(device_.heard(), 0); });
  }

  Device device_;
  SoundPlayback playback_{[this] { return std::make_unique<FakeLoudspeaker>(device_); }, seconds()};
  std::optional<PlaybackClock> clock_;
};

TEST_F(SoundPlaybackTest, IsHeardWithItsPictures) {
  clock_->play();
  pass(0.1); // until it is heard
  expect_together(2.5);
  EXPECT_NEAR(clock_->position(), 2.6, kTogether); // at its own pace
}

TEST_F(SoundPlaybackTest, HasNoGapWhenTheWindowIsKeptWaitingForNearlyHalfASecond) {
  clock_->play();
  pass(0.3);
  for (int i = 0; i < 40; ++i) { // in which nobody asks for more
    device_.pass(1.0 / 90);
    EXPECT_NEAR(4 * device_.heard(), clock_->position(), kTogether);
  }
  expect_together(0.5);
}

TEST_F(SoundPlaybackTest, FollowsSeeksAndLoops) {
  clock_->set_loop(true);
  clock_->play();
  for (const double to : {2.0, 0.37, 2.95, 0.011, 1.5}) {
    clock_->seek(to);
    pass(0.15);
    const double expected = std::fmod(to + 0.15, 3);
    EXPECT_NEAR(clock_->position(), expected, kTogether);
    expect_together(0.5);
  }
  pass(1); // over its end
  EXPECT_LT(clock_->position(), 1);
  expect_together(1);
}

TEST_F(SoundPlaybackTest, IsSilentWhilePausedOrAtAnotherSpeedAndThenGoesOn) {
  expect_silence(0.2);
  clock_->play();
  pass(0.5);
  clock_->pause();
  const double paused = clock_->position();
  pass(0.1);
  expect_silence(0.5);
  EXPECT_EQ(clock_->position(), paused);
  clock_->play();
  clock_->set_speed(2);
  expect_silence(0.5);
  EXPECT_NEAR(clock_->position(), paused + 1, 0.03);
  clock_->set_speed(1);
  pass(0.1);
  expect_together(0.5);
}

TEST_F(SoundPlaybackTest, MutedItIsSilentAndThePicturesGoOn) {
  clock_->play();
  pass(0.5);
  playback_.set_muted(true);
  pass(0.1);
  expect_silence(0.5);
  EXPECT_NEAR(clock_->position(), 1.1, kTogether);
  playback_.set_muted(false);
  pass(0.1);
  expect_together(0.5);
}

TEST_F(SoundPlaybackTest, BeginsLateAndEndsEarlyWhereTheSoundDoes) {
  playback_.set_sound(nullptr);
  pass(0.02);
  playback_.set_sound(telling_sound(1));
  clock_->play();
  expect_silence(0.9);
  pass(0.25);
  expect_together(1.5);
  pass(0.5);
  EXPECT_FALSE(clock_->playing()); // it has come to its end
}

TEST_F(SoundPlaybackTest, MoreOfTheSameSoundIsPlayedWithoutABreak) {
  const auto whole = telling_sound();
  auto begun = std::make_shared<container::Sound>(*whole);
  begun->packets.resize(50); // a second of it
  playback_.set_sound(nullptr);
  playback_.set_sound(begun);
  clock_->play();
  pass(0.5);
  playback_.set_sound(whole);
  expect_together(2);
}

TEST_F(SoundPlaybackTest, WithoutALoudspeakerTheClockGoesByItself) {
  SoundPlayback playback(
      []() -> std::unique_ptr<Loudspeaker> { throw Error(ErrorCode::kMissingComponent, "no device"); }, seconds());
  playback.set_sound(telling_sound());
  clock_->play();
  for (int i = 0; i < 90; ++i) {
    device_.pass(1.0 / 90);
    playback.follow(*clock_);
  }
  EXPECT_NEAR(clock_->position(), 1, 1e-6);
  EXPECT_EQ(playback.take_message(), "no device");
  EXPECT_EQ(playback.take_message(), "");
}

TEST_F(SoundPlaybackTest, ADeviceThatIsTakenAwayDoesNotStopThePictures) {
  clock_->play();
  pass(0.5);
  device_.broken = true;
  pass(2.2);
  EXPECT_GT(clock_->position(), 1.5);
  EXPECT_NE(playback_.take_message(), "");
}

TEST_F(SoundPlaybackTest, DamagedPacketsAreSilentAndTheRestIsHeardInTime) {
  auto damaged = std::make_shared<container::Sound>(*telling_sound());
  for (std::size_t i = 30; i < 50; ++i) damaged->packets[i].bytes.clear();
  playback_.set_sound(nullptr);
  playback_.set_sound(damaged);
  clock_->play();
  pass(1.2);
  expect_together(1);
}

TEST_F(SoundPlaybackTest, NothingIsOpenedForClipsWithoutSound) {
  playback_.set_sound(nullptr);
  clock_->play();
  pass(0.5);
  EXPECT_EQ(device_.opened, 0);
  EXPECT_NEAR(clock_->position(), 0.5, 0.02);
}

} // namespace
} // namespace kinora::player::window
