// Claims about files that our writer writes and our reader reads.
#include <gtest/gtest.h>

#include "core/error.h"
#include "ebml_builder.h"
#include "sample_file.h"

namespace kinora::container {
namespace {

using testing::load;
using testing::read_all;
using testing::sample_file;
using testing::SampleFile;
using testing::TemporaryFolder;
using testing::write_sample;

void expect_holds(Reader& reader, const SampleFile& sample) {
  EXPECT_EQ(reader.tag(kKindTag), "clip");
  EXPECT_EQ(reader.tag(kVersionTag), "1");
  EXPECT_EQ(reader.tag("TITLE"), "Ärger im Haus");
  EXPECT_EQ(reader.tag("NONE"), std::nullopt);
  ASSERT_EQ(reader.tracks().size(), sample.head.tracks.size());
  for (std::size_t i = 0; i < sample.head.tracks.size(); ++i) {
    const Track& track = reader.tracks()[i].track;
    EXPECT_TRUE(reader.tracks()[i].ours);
    EXPECT_EQ(track.id, sample.head.tracks[i].id);
    EXPECT_EQ(track.codec, sample.head.tracks[i].codec);
    EXPECT_EQ(track.name, sample.head.tracks[i].name);
    EXPECT_EQ(track.private_data, sample.head.tracks[i].private_data);
  }
  ASSERT_EQ(reader.attachments().size(), sample.head.attachments.size());
  for (std::size_t i = 0; i < sample.head.attachments.size(); ++i) {
    const StoredAttachment& stored = reader.attachments()[i];
    EXPECT_EQ(stored.name, sample.head.attachments[i].name);
    EXPECT_EQ(stored.media_type, sample.head.attachments[i].media_type);
    EXPECT_EQ(stored.description, sample.head.attachments[i].description);
    EXPECT_EQ(reader.read_attachment(stored), sample.head.attachments[i].bytes);
  }
  const std::vector<Payload> payloads = read_all(reader);
  ASSERT_EQ(payloads.size(), sample.payloads.size());
  for (std::size_t i = 0; i < payloads.size(); ++i) {
    EXPECT_EQ(payloads[i].track, sample.payloads[i].track);
    EXPECT_EQ(payloads[i].time_ns, sample.payloads[i].time_ns);
    EXPECT_EQ(payloads[i].key, sample.payloads[i].key);
    EXPECT_EQ(payloads[i].bytes, sample.payloads[i].bytes);
  }
  EXPECT_FALSE(reader.truncated());
}

TEST(ContainerRoundTrip, GivesBackTracksAttachmentsTagsAndPayloads) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    const SampleFile sample = sample_file(seed, seed * 7, 5000);
    write_sample(sample, folder / "a.mkv");
    Reader reader(folder / "a.mkv");
    expect_holds(reader, sample);
  }
}

TEST(ContainerRoundTrip, GivesBackPayloadsOfMoreThanAMegabyte) {
  const TemporaryFolder folder;
  const SampleFile sample = sample_file(3, 5, 3'000'000);
  write_sample(sample, folder / "a.mkv");
  Reader reader(folder / "a.mkv");
  expect_holds(reader, sample);
}

TEST(ContainerRoundTrip, GivesBackAFileWithoutPayloads) {
  const TemporaryFolder folder;
  const SampleFile sample = sample_file(4, 0, 1);
  write_sample(sample, folder / "a.mkv");
  Reader reader(folder / "a.mkv");
  expect_holds(reader, sample);
}

TEST(ContainerRoundTrip, KeepsTimesToTheNanosecondForHours) {
  const TemporaryFolder folder;
  SampleFile sample = sample_file(5, 0, 1);
  for (const std::int64_t time : {0LL, 1LL, 999'999LL, 86'400'000'000'001LL, 4'000'000'000'000'000LL}) {
    sample.payloads.push_back({sample.head.tracks[0].id, time, true, {}, 0, 0});
  }
  write_sample(sample, folder / "a.mkv");
  Reader reader(folder / "a.mkv");
  expect_holds(reader, sample);
}

TEST(ContainerWriter, WritesTheSameBytesForTheSameInput) {
  const TemporaryFolder folder;
  const SampleFile sample = sample_file(6, 50, 2000);
  write_sample(sample, folder / "a.mkv");
  write_sample(sample, folder / "b.mkv");
  EXPECT_EQ(load(folder / "a.mkv"), load(folder / "b.mkv"));
}

TEST(ContainerWriter, GivesOtherContentsAnotherIdentifier) {
  const TemporaryFolder folder;
  SampleFile sample = sample_file(7, 10, 200);
  write_sample(sample, folder / "a.mkv");
  Payload& largest =
      *std::max_element(sample.payloads.begin(), sample.payloads.end(),
                        [](const Payload& p, const Payload& q) { return p.bytes.size() < q.bytes.size(); });
  largest.bytes.front() ^= std::byte{1};
  write_sample(sample, folder / "b.mkv");
  const Bytes a = load(folder / "a.mkv");
  const Bytes b = load(folder / "b.mkv");
  ASSERT_EQ(a.size(), b.size());
  Bytes uid_id = testing::id_bytes(0x73A4);
  uid_id.push_back(std::byte{0x90}); // 16 bytes
  const auto uid_at = std::search(a.begin(), a.end(), uid_id.begin(), uid_id.end()) - a.begin();
  ASSERT_LT(uid_at + 19, static_cast<std::ptrdiff_t>(a.size()));
  EXPECT_FALSE(std::equal(a.begin() + uid_at, a.begin() + uid_at + 19, b.begin() + uid_at));
}

// Writes until the file is closed; the error must come, whenever the system notices.
ErrorCode code_of_writing(const std::filesystem::path& path, std::string& sentence) {
  try {
    write_sample(sample_file(8, 4, 100), path);
  } catch (const Error& error) {
    sentence = error.what();
    return error.code();
  }
  return ErrorCode::kFailure;
}

TEST(ContainerWriter, SaysThatADiskIsFull) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  std::string sentence;
  EXPECT_EQ(code_of_writing("/dev/full", sentence), ErrorCode::kUnwritableOutput);
  EXPECT_NE(sentence.find("/dev/full"), std::string::npos) << sentence;
}

TEST(ContainerWriter, SaysThatADiskIsFullInTheMiddleOfALongFile) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  const SampleFile sample = sample_file(9, 40, 1'000'000);
  EXPECT_THROW(write_sample(sample, "/dev/full"), Error);
}

TEST(ContainerWriter, SaysThatAFolderIsMissing) {
  const TemporaryFolder folder;
  std::string sentence;
  EXPECT_EQ(code_of_writing(folder / "missing/a.mkv", sentence), ErrorCode::kUnwritableOutput);
  EXPECT_NE(sentence.find("missing/a.mkv"), std::string::npos) << sentence;
}

TEST(ContainerWriter, RefusesTimesThatRunBackwards) {
  const TemporaryFolder folder;
  Writer writer(folder / "a.mkv", {"clip", {{1, "S_KINORA/FIELD", "", {}}}, {}, {}, 0});
  writer.write(1, 10, true, {});
  EXPECT_THROW(writer.write(1, 9, true, {}), Error);
}

TEST(ContainerWriter, RefusesTracksAndAttachmentsThatCannotBeToldApart) {
  const TemporaryFolder folder;
  const Track track{1, "S_KINORA/FIELD", "", {}};
  EXPECT_THROW(Writer(folder / "a.mkv", {"clip", {track, track}, {}, {}, 0}), Error);
  EXPECT_THROW(Writer(folder / "a.mkv", {"clip", {{1, "V_VP9", "", {}}}, {}, {}, 0}), Error);
  const Attachment attachment{"a.json", "application/json", "", {}};
  EXPECT_THROW(Writer(folder / "a.mkv", {"clip", {track}, {attachment, attachment}, {}, 0}), Error);
  EXPECT_THROW(Writer(folder / "a.mkv", {"clip", {}, {}, {}, 0}), Error);
}

TEST(ContainerReader, AccountsForEveryByteOfAPayload) {
  const TemporaryFolder folder;
  const SampleFile sample = sample_file(10, 30, 400);
  write_sample(sample, folder / "a.mkv");
  Reader reader(folder / "a.mkv");
  std::uint64_t end = 0;
  for (const Payload& payload : read_all(reader)) {
    EXPECT_GE(payload.offset, end);
    EXPECT_GE(payload.stored_bytes, payload.bytes.size() + kEnvelopeBytes);
    end = payload.offset + payload.stored_bytes;
  }
  EXPECT_LE(end, reader.file_bytes());
}

} // namespace
} // namespace kinora::container
