// Claims about what is saved of a damaged file.
#include <fstream>

#include <gtest/gtest.h>

#include "container/recovery.h"
#include "core/error.h"
#include "ebml_builder.h"
#include "sample_file.h"

namespace kinora::container {
namespace {

using namespace testing;

void store(const std::filesystem::path& path, const Bytes& bytes, std::size_t size) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(size));
}

TEST(ContainerRecovery, SavesAllThatIsSoundOfADamagedFile) {
  const TemporaryFolder folder;
  const SampleFile sample = sample_file(81, 50, 3000);
  write_sample(sample, folder / "a.mkv");
  Bytes bytes = load(folder / "a.mkv");
  for (std::size_t i = bytes.size() / 2; i < bytes.size() / 2 + 10; ++i) bytes[i] = std::byte{0};
  store(folder / "damaged.mkv", bytes, bytes.size() - 5000);
  Progress progress;
  const Recovery recovery = recover(folder / "damaged.mkv", folder / "saved.mkv", progress);
  EXPECT_TRUE(recovery.lost_anything());
  EXPECT_GE(recovery.damage.entries().size(), 2U);
  EXPECT_LT(recovery.payloads, 50U);
  EXPECT_GT(recovery.payloads, 30U);
  Reader saved(folder / "saved.mkv");
  EXPECT_EQ(saved.tag("TITLE"), "Ärger im Haus");
  EXPECT_EQ(saved.attachments().size(), sample.head.attachments.size());
  EXPECT_EQ(read_all(saved).size(), recovery.payloads);
}

TEST(ContainerRecovery, SavesEveryPrefixOfAFileOrSaysWhyNot) {
  const TemporaryFolder folder;
  write_sample(sample_file(82, 6, 60), folder / "a.mkv");
  const Bytes bytes = load(folder / "a.mkv");
  Reader whole(folder / "a.mkv");
  std::vector<std::uint64_t> ends;
  for (const Payload& payload : read_all(whole)) ends.push_back(payload.offset + payload.stored_bytes);
  Progress progress;
  for (std::size_t size = 0; size < bytes.size(); size += size + 40 < ends.front() ? 23 : 1) {
    store(folder / "cut.mkv", bytes, size);
    const auto expected = std::count_if(ends.begin(), ends.end(), [&](std::uint64_t end) { return end <= size; });
    try {
      EXPECT_EQ(recover(folder / "cut.mkv", folder / "saved.mkv", progress).payloads,
                static_cast<std::size_t>(expected));
    } catch (const Error& error) {
      EXPECT_EQ(expected, 0) << size << ": " << error.what();
      EXPECT_TRUE(error.code() == ErrorCode::kCorruptInput || error.code() == ErrorCode::kNotRecognised);
      EXPECT_NE(std::string(error.what()).find("cut.mkv"), std::string::npos) << error.what();
    }
  }
}

TEST(ContainerRecovery, FindsNothingLostOfASoundFileAndKeepsTracksOfOthers) {
  const TemporaryFolder folder;
  Track video{9, "V_MJPEG", "colour", bytes_of("private")};
  video.media = MediaFormat{64, 48};
  Track sound{10, "A_PCM/INT/LIT", "sound", {}};
  sound.media = MediaFormat{.sampling_rate = 48'000, .channels = 2, .bits = 16};
  {
    Writer writer(folder / "a.mkv", {"recording", {{7, "S_KINORA/FRAMES", "", {}}, video, sound}, {}, {}, 0});
    writer.write(9, 0, true, bytes_of("picture"));
    writer.write(7, 0, true, bytes_of("payload"));
    writer.write(10, 7'000'000, true, bytes_of("sound"));
    writer.finish();
  }
  Progress progress;
  const Recovery recovery = recover(folder / "a.mkv", folder / "b.mkv", progress);
  EXPECT_FALSE(recovery.lost_anything());
  EXPECT_EQ(recovery.blocks, 2U);
  Reader reader(folder / "b.mkv");
  ASSERT_EQ(reader.tracks().size(), 3U);
  EXPECT_EQ(reader.tracks()[1].track.media->width, 64);
  EXPECT_EQ(reader.tracks()[2].track.media->sampling_rate, 48'000);
  EXPECT_EQ(reader.tracks()[2].track.media->channels, 2);
  StoredBlock block;
  std::vector<Bytes> blocks;
  while (reader.next_block(block)) blocks.push_back(reader.read_block(block));
  ASSERT_EQ(blocks.size(), 3U);
  EXPECT_EQ(blocks[0], bytes_of("picture"));
  EXPECT_EQ(blocks[2], bytes_of("sound"));
}

} // namespace
} // namespace kinora::container
