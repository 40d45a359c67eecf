// Sound through the commands: recorded, converted, encoded, cut and joined.
#include <cstdlib>
#include <numeric>

#include "cli/run_kinora.h"
#include "clip/clip_io.h"
#include "recording/recording_file.h"
#include "sound/sample_sound.h"

namespace kinora::test {
namespace {

class WithSound : public ::testing::Test {
protected:
  Said run(const std::vector<std::string>& words) { return run_kinora(folder_, words); }
  void run_well(const std::vector<std::string>& words) {
    const Said said = run(words);
    ASSERT_EQ(said.code, 0) << said.err;
  }
  std::string path(const char* name) const { return (folder_.path() / name).string(); }
  void SetUp() override {
    samples_ = write_tone(path("tone.wav"), 4, 0.5, 1.5);
    run_well({"record", capture_, path("r.mkv"), "--audio", path("tone.wav")});
  }

  TemporaryFolder folder_;
  std::string capture_ = KINORA_SAMPLES "/carry_box";
  std::vector<std::int16_t> samples_;
};

container::Bytes sound_of(const std::string& recording) {
  recording::RecordingFile file(recording);
  container::Bytes bytes;
  for (std::size_t i = 0; i < file.sound_packet_count(); ++i) {
    const container::Payload packet = file.read_sound(i);
    bytes.insert(bytes.end(), packet.bytes.begin(), packet.bytes.end());
  }
  return bytes;
}

TEST_F(WithSound, ARecordingKeepsItBitByBitUpToItsLastFrame) {
  const container::Bytes kept = sound_of(path("r.mkv"));
  const auto original = std::as_bytes(std::span(samples_));
  ASSERT_GT(kept.size(), 16'000U * 2 * 17 / 10); // 1.8 s of frames
  ASSERT_LT(kept.size(), original.size());
  EXPECT_TRUE(std::equal(kept.begin(), kept.end(), original.begin()));
  run_well({"validate", path("r.mkv")});
  EXPECT_NE(run({"info", path("r.mkv")}).out.find("capture sound"), std::string::npos);
  const std::string probe = "ffprobe -v error -select_streams a -show_entries stream=codec_name -of csv=p=0 '" +
                            path("r.mkv") + "' > '" + path("said") + "'";
  ASSERT_EQ(std::system(probe.c_str()), 0);
  EXPECT_EQ(contents_of(path("said")), "pcm_s16le\n");
}

TEST_F(WithSound, ARecordingOfARecordingHasTheSame) {
  run_well({"record", path("r.mkv"), path("again.mkv")});
  EXPECT_EQ(sound_of(path("again.mkv")), sound_of(path("r.mkv")));
  run_well({"convert", path("r.mkv"), path("converted.mkv"), "--to", "kinora-recording"});
  EXPECT_EQ(sound_of(path("converted.mkv")), sound_of(path("r.mkv")));
}

TEST_F(WithSound, AFormatWithoutAPlaceForItSaysSo) {
  const Said said = run({"convert", path("r.mkv"), path("folder"), "--to", "tum-rgbd", "--frames", "0:2"});
  EXPECT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.err.find("has sound"), std::string::npos) << said.err;
  expect_error(run({"convert", path("r.mkv"), path("strict"), "--to", "tum-rgbd", "--strict"}), 1, "has sound");
}

TEST_F(WithSound, DamagedAndMissingPacketsAreNoticed) {
  std::string bytes = contents_of(path("r.mkv"));
  recording::RecordingFile file(path("r.mkv"));
  const container::Payload packet = file.read_sound(file.sound_packet_count() / 3);
  const auto at = bytes.find(std::string(reinterpret_cast<const char*>(packet.bytes.data()), packet.bytes.size()));
  ASSERT_NE(at, std::string::npos);
  bytes[at + 100] = static_cast<char>(bytes[at + 100] ^ 1);
  folder_.write("bad.mkv", bytes);
  expect_error(run({"validate", path("bad.mkv")}), 4, "packet of sound is damaged");
  run_well({"record", path("bad.mkv"), path("rest.mkv")}); // without it
  EXPECT_EQ(sound_of(path("rest.mkv")).size(), sound_of(path("r.mkv")).size() - packet.bytes.size());
}

/// When each packet is, and its bytes.
std::vector<std::pair<std::int64_t, container::Bytes>> packets_of(const std::string& clip) {
  std::vector<std::pair<std::int64_t, container::Bytes>> packets;
  const clip::Clip whole = clip::read_clip(clip);
  if (!whole.sound) return packets;
  EXPECT_EQ(whole.sound->track.codec, "A_OPUS");
  for (const container::Payload& packet : whole.sound->packets) packets.emplace_back(packet.time_ns, packet.bytes);
  return packets;
}

TEST_F(WithSound, AClipHasItAsOpusWhichIsCutAndJoinedWithIt) {
  run_well({"encode", path("r.mkv"), path("clip.mkv"), "--preset", "fast", "--frames", "15:25", "--archive"});
  const auto packets = packets_of(path("clip.mkv"));
  ASSERT_GE(packets.size(), 15U); // a third of a second, 20 ms each
  EXPECT_LE(packets.size(), 19U);
  EXPECT_EQ(packets.front().first, 0);
  EXPECT_EQ(sound_of(path("clip.mkv")), sound_of(path("r.mkv"))); // beside it
  EXPECT_NE(run({"info", path("clip.mkv")}).out.find("sound"), std::string::npos);
  run_well({"validate", path("clip.mkv")});
  // The tone begins half a second after the first frame of all, which is where this clip begins.
  double energy = 0;
  for (const auto& [time, bytes] : packets) energy += static_cast<double>(bytes.size());
  EXPECT_GT(energy / static_cast<double>(packets.size()), 60); // bytes; silence takes 3

  run_well({"encode", path("r.mkv"), path("plain.mkv"), "--preset", "fast", "--frames", "15:25"});
  EXPECT_EQ(packets_of(path("plain.mkv")), packets);
  run_well({"cut", path("plain.mkv"), path("a.mkv"), "--frames", "0:5"});
  run_well({"cut", path("plain.mkv"), path("b.mkv"), "--frames", "5:10"});
  EXPECT_LT(packets_of(path("a.mkv")).size(), packets.size());
  run_well({"join", path("a.mkv"), path("b.mkv"), path("joined.mkv")});
  EXPECT_EQ(packets_of(path("joined.mkv")), packets);

  if (std::system("command -v mkvmerge > /dev/null 2>&1") != 0) return;
  // It puts several packets into one block.
  ASSERT_EQ(std::system(fmt::format("mkvmerge -q -o {} {}", path("remuxed.mkv"), path("plain.mkv")).c_str()), 0);
  const auto remuxed = packets_of(path("remuxed.mkv"));
  ASSERT_EQ(remuxed.size(), packets.size());
  for (std::size_t i = 0; i < packets.size(); ++i) {
    EXPECT_EQ(remuxed[i].second, packets[i].second) << i;
    EXPECT_NEAR(static_cast<double>(remuxed[i].first), static_cast<double>(packets[i].first), 1.5e6) << i; // ns
  }
}

TEST_F(WithSound, AFileThatIsNoSoundIsRefusedBeforeAnythingIsDone) {
  folder_.write("text.wav", "no sound");
  expect_error(run({"encode", capture_, path("c.mkv"), "--audio", path("text.wav")}), 4, "text.wav");
  expect_error(run({"record", capture_, path("x.mkv"), "--audio", path("text.wav")}), 4, "text.wav");
  expect_error(run({"record", capture_, path("x.mkv"), "--audio", path("none.wav")}), 2, "none.wav");
  EXPECT_FALSE(fs::exists(path("c.mkv")) || fs::exists(path("x.mkv")));
}

} // namespace
} // namespace kinora::test
