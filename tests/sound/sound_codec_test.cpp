// Sound out of files, to Opus and to samples.
#include "sound/sound_codec.h"

#include <cmath>
#include <cstdlib>
#include <cstring>

#include <gtest/gtest.h>

#include "core/error.h"
#include "formats/sample_capture.h"
#include "sample_sound.h"

namespace kinora::sound {
namespace {

using test::TemporaryFolder;
using test::write_tone;

constexpr std::int64_t kSecond = 1'000'000'000;

container::Sound all_of(const std::string& path) {
  const auto source = open_sound(path);
  return excerpt(*source, 0, INT64_MAX - 1);
}

/// When sound is first and last heard, seconds.
std::pair<double, double> heard(const container::Sound& sound) {
  const auto decoder = make_sound_decoder(sound.track);
  double first = -1;
  double last = -1;
  for (const container::Payload& packet : sound.packets) {
    const std::vector<float> samples = decoder->decode(packet);
    const double begin = static_cast<double>(packet.time_ns - sound.track.media->delay_ns) / 1e9;
    for (std::size_t i = 0; i < samples.size(); i += kPlayedChannels) {
      EXPECT_EQ(samples[i], samples[i + 1]); // of one channel
      if (std::abs(samples[i]) < 0.1F) continue;
      const double t = begin + static_cast<double>(i) / (kPlayedChannels * kPlayedRate);
      if (first < 0) first = t;
      last = t;
    }
  }
  return {first, last};
}

class SoundCodec : public ::testing::Test {
protected:
  std::string path(const char* name) const { return (folder_.path() / name).string(); }
  /// The tone in another format, by FFmpeg's program.
  void make(const std::string& options, const char* to) {
    const std::string command =
        "ffmpeg -v error -y -i '" + path("tone.wav") + "' " + options + " '" + path(to) + "' < /dev/null";
    ASSERT_EQ(std::system(command.c_str()), 0);
  }

  TemporaryFolder folder_;
};

TEST_F(SoundCodec, SamplesOfAWaveFileAreKeptBitByBit) {
  const std::vector<std::int16_t> samples = write_tone(path("tone.wav"), 1.5, 0, 1.5, 44'100, 2);
  const container::Sound sound = all_of(path("tone.wav"));
  EXPECT_EQ(sound.track.codec, "A_PCM/INT/LIT");
  EXPECT_EQ(sound.track.media->sampling_rate, 44'100);
  EXPECT_EQ(sound.track.media->channels, 2);
  EXPECT_EQ(sound.track.media->bits, 16);
  container::Bytes bytes;
  for (const container::Payload& packet : sound.packets) {
    EXPECT_EQ(packet.time_ns, std::llround(static_cast<double>(bytes.size()) / 4 * 1e9 / 44'100));
    bytes.insert(bytes.end(), packet.bytes.begin(), packet.bytes.end());
  }
  ASSERT_EQ(bytes.size(), samples.size() * 2);
  EXPECT_EQ(std::memcmp(bytes.data(), samples.data(), bytes.size()), 0);
}

TEST_F(SoundCodec, OpusIsHeardWhenTheOriginalIs) {
  write_tone(path("tone.wav"), 2, 0.5, 1.25);
  const container::Sound opus = compact(all_of(path("tone.wav")));
  EXPECT_EQ(opus.track.codec, "A_OPUS");
  EXPECT_GT(opus.track.media->delay_ns, 0);
  std::size_t bytes = 0;
  for (const container::Payload& packet : opus.packets) bytes += packet.bytes.size();
  EXPECT_LT(bytes, 2 * 16'000U); // of 64 000
  const auto [first, last] = heard(opus);
  EXPECT_NEAR(first, 0.5, 0.005);
  EXPECT_NEAR(last, 1.25, 0.005);
}

TEST_F(SoundCodec, ForeignFilesAreHeardAtTheirTime) {
  write_tone(path("tone.wav"), 2, 0.5, 1.25);
  struct Case {
    const char* file;
    const char* options;
    const char* codec;
    double tolerance; // a stream of AAC without a file around it does not say what its encoder put first
  };
  for (const Case& c :
       {Case{"tone.ogg", "-c:a libopus", "A_OPUS", 0.005}, Case{"tone.flac", "", "A_FLAC", 0.005},
        Case{"tone.mka", "-c:a libopus", "A_OPUS", 0.005}, Case{"v.ogg", "-c:a libvorbis", "A_VORBIS", 0.005},
        Case{"tone.m4a", "-c:a aac", "A_AAC", 0.005}, Case{"tone.mp3", "-c:a libmp3lame", "A_MPEG/L3", 0.005},
        Case{"raw.aac", "-c:a aac", "A_PCM/INT/LIT", 0.08},
        Case{"law.wav", "-c:a pcm_mulaw", "A_PCM/INT/LIT", 0.005}}) {
    SCOPED_TRACE(c.file);
    make(c.options, c.file);
    const container::Sound sound = all_of(path(c.file));
    EXPECT_EQ(sound.track.codec, c.codec);
    ASSERT_FALSE(sound.packets.empty());
    for (std::size_t i = 1; i < sound.packets.size(); ++i)
      EXPECT_GE(sound.packets[i].time_ns, sound.packets[i - 1].time_ns);
    const auto [first, last] = heard(sound);
    EXPECT_NEAR(first, 0.5, c.tolerance);
    EXPECT_NEAR(last, 1.25, c.tolerance);
    const auto [small_first, small_last] = heard(compact(sound));
    EXPECT_NEAR(small_first, 0.5, c.tolerance + 0.005);
    EXPECT_NEAR(small_last, 1.25, c.tolerance + 0.005);
  }
}

TEST_F(SoundCodec, ExcerptBeginsAndEndsAsAsked) {
  write_tone(path("tone.wav"), 3, 1, 2);
  const auto source = open_sound(path("tone.wav"));
  const container::Sound middle = excerpt(*source, kSecond / 2, kSecond * 3 / 2);
  const auto [first, last] = heard(middle);
  EXPECT_NEAR(first, 0.5, 0.005);
  EXPECT_LE(middle.packets.front().time_ns, 0);
  EXPECT_LE(middle.packets.back().time_ns, kSecond);
  EXPECT_GT(last, 0.95);
}

TEST_F(SoundCodec, AClipsSoundBeginsAtItsBeginningInTheMiddleOfAPacket) {
  write_tone(path("tone.wav"), 3, 0, 3);
  for (const std::int64_t begin : {kSecond / 2, kSecond * 7 / 10, kSecond}) { // packets are 128 ms long
    const auto source = open_sound(path("tone.wav"));
    const container::Sound opus = compact(excerpt(*source, begin, begin + kSecond));
    EXPECT_EQ(opus.packets.front().time_ns, 0);
    EXPECT_NEAR(heard(opus).first, 0, 0.005);
  }
}

TEST_F(SoundCodec, FilesWithoutSoundAreRefused) {
  folder_.write("text.wav", "this is no sound at all, though it is named so");
  folder_.write("empty.mp3", "");
  for (const char* name : {"text.wav", "empty.mp3"}) {
    try {
      open_sound(path(name));
      ADD_FAILURE() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos);
    }
  }
}

TEST_F(SoundCodec, DamagedPacketsDoNotStopTheDecoder) {
  write_tone(path("tone.wav"), 1, 0, 1);
  container::Sound opus = compact(all_of(path("tone.wav")));
  for (std::size_t i = 0; i < opus.packets.size(); i += 3)
    for (std::byte& byte : opus.packets[i].bytes) byte ^= std::byte{0x5A};
  const auto decoder = make_sound_decoder(opus.track);
  std::size_t samples = 0;
  for (const container::Payload& packet : opus.packets)
    for (const float value : decoder->decode(packet)) samples += std::isfinite(value) ? 1 : 0;
  EXPECT_GT(samples, static_cast<std::size_t>(kPlayedRate)); // of twice as many
}

TEST_F(SoundCodec, UnknownCodecsAreRefused) {
  container::Track track;
  track.codec = "A_TONES";
  track.media.emplace();
  EXPECT_THROW(make_sound_decoder(track), Error);
}

} // namespace
} // namespace kinora::sound
