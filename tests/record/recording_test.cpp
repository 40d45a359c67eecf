// Recordings of every kind of picture: they read back as they were, and survive being cut anywhere.
#include <algorithm>
#include <array>
#include <utility>

#include "container/recovery.h"
#include "core/error.h"
#include "core/random.h"
#include "formats/sample_capture.h"
#include "host/frame_reader.h"
#include "host/plugin_table.h"
#include "record/sample_recording.h"
#include "recording/recording_file.h"

namespace kinora::test {
namespace {

std::vector<std::byte> bytes_of(const KinoraImage& image) {
  if (image.data == nullptr) return {};
  const auto* from = static_cast<const std::byte*>(image.data);
  return {from, from + image.row_bytes * static_cast<std::size_t>(image.height)};
}

void expect_same(const KinoraFrame& a, const KinoraFrame& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.depth_unit, b.depth_unit);
  EXPECT_EQ(bytes_of(a.color), bytes_of(b.color));
  EXPECT_EQ(bytes_of(a.depth), bytes_of(b.depth));
  EXPECT_EQ(bytes_of(a.infrared), bytes_of(b.infrared));
  EXPECT_EQ(bytes_of(a.confidence), bytes_of(b.confidence));
  EXPECT_EQ(bytes_of(a.labels), bytes_of(b.labels));
  EXPECT_EQ(a.has_pose, b.has_pose);
  for (int i = 0; i < 16; ++i) EXPECT_EQ(a.camera_to_world[i], b.camera_to_world[i]);
}

/// Frames that can be read, each of them checked to be what was recorded; the others' sentences go to `problems`.
std::size_t expect_sound_frames(const fs::path& path, std::vector<std::string>& problems) {
  static const host::PluginTable plugins = host::PluginTable::builtin();
  host::FrameReader reader(plugins.find("kinora-recording"), path, {});
  const recording::RecordingFile file(path);
  std::size_t sound = 0;
  while (const auto read = reader.next()) {
    if (!read->problem.empty()) {
      problems.push_back(read->problem);
      continue;
    }
    ++sound;
    const auto place = static_cast<std::size_t>(read->frame.index);
    expect_same(read->frame, SampleFrame(static_cast<int>(file.record(place).index)).frame);
  }
  return sound;
}

class Recording : public ::testing::Test {
protected:
  static Bytes read(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
  }
  /// Frames that recovering `bytes` saves; none if it refuses, which it must explain.
  std::size_t recovered(std::span<const std::byte> bytes) {
    fs::remove(folder_.path() / "broken.mkv"); // some file systems wait for the disk when a file is replaced
    fs::remove(saved_);
    folder_.write("broken.mkv", bytes);
    try {
      container::recover(folder_.path() / "broken.mkv", saved_, quiet_);
      std::vector<std::string> problems;
      return expect_sound_frames(saved_, problems);
    } catch (const Error& error) {
      EXPECT_TRUE(error.code() == ErrorCode::kCorruptInput || error.code() == ErrorCode::kNotRecognised)
          << error.what();
      EXPECT_GT(std::string(error.what()).size(), 20U);
      return 0;
    }
  }

  TemporaryFolder folder_;
  fs::path path_ = folder_.path() / "r.mkv";
  fs::path saved_ = folder_.path() / "saved.mkv";
  Progress quiet_;
};

TEST_F(Recording, KeepsEveryPictureAndPoseBitByBit) {
  write_sample_recording(path_, 5);
  std::vector<std::string> problems;
  EXPECT_EQ(expect_sound_frames(path_, problems), 5U);
  EXPECT_TRUE(problems.empty());
  const recording::Description description = recording::RecordingFile(path_).description();
  EXPECT_EQ(recording::to_json(description), recording::to_json(sample_description()));
}

TEST_F(Recording, FrameWithoutPoseHasNone) {
  const SampleFrame first(0, false);
  record::Recorder recorder(path_, sample_description(), first.frame);
  recorder.write(first.frame);
  recorder.finish();
  EXPECT_FALSE(recording::RecordingFile(path_).record(0).camera_to_world.has_value());
}

TEST_F(Recording, FrameOfAnotherSizeIsRefusedAndSaysWhy) {
  const SampleFrame first(0);
  record::Recorder recorder(path_, sample_description(), first.frame);
  EXPECT_TRUE(recorder.write(first.frame));
  SampleFrame second(1);
  second.frame.depth.height -= 1;
  EXPECT_FALSE(recorder.write(second.frame));
  recorder.finish();
  const recording::RecordingFile file(path_);
  ASSERT_EQ(file.frame_count(), 2U);
  EXPECT_NE(file.record(1).problem.find("capture depth is 12x9"), std::string::npos) << file.record(1).problem;
}

TEST_F(Recording, EveryPrefixIsRecoveredOrRefused) {
  write_sample_recording(path_, 2);
  const Bytes whole = read(path_);
  std::size_t before = 0;
  for (std::size_t length = 0; length <= whole.size(); ++length) {
    SCOPED_TRACE(length);
    const std::size_t frames = recovered(std::span(whole).first(length));
    EXPECT_GE(frames, before);
    before = frames;
    if (HasFailure()) return;
  }
  EXPECT_EQ(before, 2U);
}

// Without the head, which says how to decode pictures, none of them can be read. Behind it a bit that stands in a
// picture costs its frame; one in the size of a block may cost what follows in its cluster as well.
TEST_F(Recording, FlippedBitGivesNoWrongPictureAndBehindTheHeadHardlyEverCostsBothFrames) {
  write_sample_recording(path_, 2);
  Bytes damaged = read(path_);
  constexpr std::array kCluster{std::byte{0x1F}, std::byte{0x43}, std::byte{0xB6}, std::byte{0x75}};
  const auto head = std::search(damaged.begin(), damaged.end(), kCluster.begin(), kCluster.end()) - damaged.begin();
  ASSERT_LT(head, std::ssize(damaged));
  Random random(7);
  std::size_t behind = 0, both_lost = 0;
  for (std::size_t i = random.below(3); i < damaged.size(); i += 1 + random.below(5)) {
    SCOPED_TRACE(i);
    const auto bit = static_cast<std::byte>(1U << random.below(8));
    damaged[i] ^= bit;
    const std::size_t saved = recovered(damaged);
    damaged[i] ^= bit;
    if (HasFailure()) return;
    if (std::cmp_less(i, head)) continue;
    ++behind;
    both_lost += saved == 0 ? 1 : 0;
  }
  EXPECT_GT(behind, 1000U);
  EXPECT_LT(100 * both_lost, behind);
}

} // namespace
} // namespace kinora::test
