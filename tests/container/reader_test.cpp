// Claims about the reader on files of others: every form that Matroska allows, and every form that it does not.
#include <gtest/gtest.h>

#include "core/error.h"
#include "ebml_builder.h"
#include "sample_file.h"

namespace kinora::container {
namespace {

using namespace testing;

const Bytes kHello = bytes_of("hello");

Bytes frame(std::uint16_t id = 7, std::int64_t time = 5) { return wrap_payload(id, time, true, kHello); }
Bytes tracks() { return element(ids::kTracks, track_entry(1, 7)); }
Bytes cluster() { return element(ids::kCluster, number(0xE7, 0) + simple_block(1, frame())); }
Bytes file_of(const Bytes& segment_body) { return ebml_head() + element(ids::kSegment, segment_body); }

void expect_one_hello(const Bytes& file) {
  Reader reader = open(file);
  const std::vector<Payload> payloads = read_all(reader);
  ASSERT_EQ(payloads.size(), 1U);
  EXPECT_EQ(payloads[0].bytes, kHello);
  EXPECT_EQ(payloads[0].track, 7);
  EXPECT_EQ(payloads[0].time_ns, 5);
  EXPECT_TRUE(payloads[0].key);
}

// The error must name the file and a byte in it.
void expect_corrupt(const Bytes& file, const std::string& word) {
  try {
    Reader reader = open(file);
    read_all(reader);
    FAIL() << "read without an error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCorruptInput) << error.what();
    EXPECT_EQ(std::string(error.what()).rfind("memory.mkv: byte ", 0), 0U) << error.what();
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

void expect_not_recognised(const Bytes& file) {
  try {
    open(file);
    FAIL() << "opened without an error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kNotRecognised) << error.what();
  }
}

TEST(ContainerReader, ReadsSimpleBlocks) { expect_one_hello(file_of(tracks() + cluster())); }

TEST(ContainerReader, ReadsBlockGroups) {
  const Bytes group = element(ids::kBlockGroup, element(ids::kBlock, block(1, frame())) + number(0x9B, 40));
  expect_one_hello(file_of(tracks() + element(ids::kCluster, group)));
}

TEST(ContainerReader, ReadsASegmentOfUnknownSize) {
  expect_one_hello(ebml_head() + unknown_size(ids::kSegment, tracks() + cluster()));
}

TEST(ContainerReader, ReadsAClusterOfUnknownSizeUpToTheNextElement) {
  const Bytes open_cluster = unknown_size(ids::kCluster, number(0xE7, 0) + simple_block(1, frame()));
  expect_one_hello(file_of(tracks() + open_cluster));
  expect_one_hello(file_of(tracks() + unknown_size(ids::kCluster, {}) + open_cluster + element(ids::kCues, {})));
  expect_one_hello(ebml_head() + unknown_size(ids::kSegment, tracks() + open_cluster + element(ids::kTags, {})));
}

TEST(ContainerReader, FindsTracksAndTagsBehindTheClusters) {
  const Bytes simple = element(ids::kSimpleTag, text(ids::kTagName, "KINORA_KIND") + text(ids::kTagString, "clip"));
  const Bytes file = file_of(cluster() + element(ids::kTags, element(ids::kTag, simple)) + tracks());
  expect_one_hello(file);
  EXPECT_EQ(open(file).tag(kKindTag), "clip");
}

TEST(ContainerReader, PassesOverVoidChecksumsAndUnknownElements) {
  const Bytes noise = element(0xEC, Bytes(30)) + element(0xBF, Bytes(4)) + element(0x1ABCDEF0, Bytes(9));
  expect_one_hello(ebml_head() + noise +
                   element(ids::kSegment, noise + element(ids::kTracks, noise + track_entry(1, 7, noise)) + noise +
                                              element(ids::kCluster, noise + simple_block(1, frame()) + noise)));
}

TEST(ContainerReader, PassesOverTracksOfOthers) {
  const Bytes video = element(ids::kTrackEntry, number(ids::kTrackNumber, 2) + text(ids::kCodecId, "V_VP9"));
  const Bytes laced = simple_block(2, bytes_of("anything"), 0x06);
  const Bytes file = file_of(element(ids::kTracks, video + track_entry(1, 7)) +
                             element(ids::kCluster, laced + simple_block(1, frame()) + laced));
  expect_one_hello(file);
  EXPECT_FALSE(open(file).tracks()[0].ours);
}

TEST(ContainerReader, UndoesHeaderStripping) {
  const Bytes whole = frame();
  const Bytes prefix(whole.begin(), whole.begin() + 3);
  const Bytes compression =
      element(ids::kContentCompression, number(ids::kContentCompAlgo, 3) + element(ids::kContentCompSettings, prefix));
  const Bytes encodings = element(ids::kContentEncodings, element(ids::kContentEncoding, compression));
  expect_one_hello(file_of(element(ids::kTracks, track_entry(1, 7, encodings)) +
                           element(ids::kCluster, simple_block(1, Bytes(whole.begin() + 3, whole.end())))));
}

TEST(ContainerReader, RefusesTracksThatWereCompressedAgain) {
  const Bytes compression = element(ids::kContentCompression, number(ids::kContentCompAlgo, 0));
  const Bytes encodings = element(ids::kContentEncodings, element(ids::kContentEncoding, compression));
  expect_corrupt(file_of(element(ids::kTracks, track_entry(1, 7, encodings))), "compressed");
}

TEST(ContainerReader, RefusesLacing) {
  expect_corrupt(file_of(tracks() + element(ids::kCluster, simple_block(1, frame(), 0x02))), "lacing");
}

TEST(ContainerReader, RejectsPayloadWithWrongChecksum) {
  Bytes damaged = frame();
  damaged.back() ^= std::byte{1};
  expect_corrupt(file_of(tracks() + element(ids::kCluster, simple_block(1, damaged))), "checksum");
}

TEST(ContainerReader, RejectsPayloadOfAnotherTrack) {
  expect_corrupt(file_of(tracks() + element(ids::kCluster, simple_block(1, frame(8)))), "lies in track 7");
}

TEST(ContainerReader, RejectsPayloadTooShortForItsEnvelope) {
  expect_corrupt(file_of(tracks() + element(ids::kCluster, simple_block(1, Bytes(15)))), "too short");
}

TEST(ContainerReader, RejectsBlockOfUnlistedTrack) {
  expect_corrupt(file_of(tracks() + element(ids::kCluster, simple_block(2, frame()))), "does not list");
}

TEST(ContainerReader, RejectsBlockWithoutTimeAndFlags) {
  const Bytes stump = element(ids::kSimpleBlock, big_endian(0x81, 1) + big_endian(0, 2));
  expect_corrupt(file_of(tracks() + element(ids::kCluster, stump)), "time and flags");
}

TEST(ContainerReader, RejectsTracksWithTheSameNumberOrId) {
  expect_corrupt(file_of(element(ids::kTracks, track_entry(1, 7) + track_entry(1, 8))), "number 1");
  expect_corrupt(file_of(element(ids::kTracks, track_entry(1, 7) + track_entry(2, 7))), "id 7");
}

TEST(ContainerReader, RejectsElementThatPassesItsParent) {
  Bytes too_long = id_bytes(ids::kSimpleBlock) + big_endian(1000 | std::uint64_t{1} << 56, 8) + Bytes(10);
  expect_corrupt(file_of(tracks() + element(ids::kCluster, too_long) + element(0xEC, Bytes(2000))), "passes the end");
}

TEST(ContainerReader, RejectsUnknownSizeWhereNoneMayBe) {
  expect_corrupt(file_of(unknown_size(ids::kTracks, track_entry(1, 7))), "unknown size");
  expect_corrupt(file_of(tracks() + element(ids::kCluster, unknown_size(ids::kBlockGroup, {}))), "unknown size");
}

TEST(ContainerReader, RejectsFileWithoutTracks) { expect_corrupt(file_of(cluster()), "without a list of tracks"); }

TEST(ContainerReader, RejectsPrivateDataThatIsDamaged) {
  Bytes file = file_of(tracks());
  const Bytes word = bytes_of("private");
  *std::search(file.begin(), file.end(), word.begin(), word.end()) ^= std::byte{4};
  expect_corrupt(file, "private data");
}

TEST(ContainerReader, RejectsAttachmentWithWrongChecksum) {
  const Bytes data = bytes_of("{\"a\": 1}");
  const auto file_with = [&](const Bytes& stored) {
    return file_of(tracks() +
                   element(ids::kAttachments,
                           element(ids::kAttachedFile, text(ids::kFileName, "a.json") +
                                                           text(ids::kFileDescription, with_checksum("A", data)) +
                                                           element(ids::kFileData, stored))));
  };
  const Bytes whole = file_with(data);
  Reader reader = open(whole);
  EXPECT_EQ(reader.read_attachment(*reader.find_attachment("a.json")), data);
  const Bytes damaged = file_with(bytes_of("{\"a\": 2}"));
  Reader damaged_reader = open(damaged);
  EXPECT_THROW(damaged_reader.read_attachment(*damaged_reader.find_attachment("a.json")), Error);
}

TEST(ContainerReader, ReadsWebM) {
  EXPECT_EQ(open(ebml_head("webm") + element(ids::kSegment, tracks())).tracks().size(), 1U);
}

TEST(ContainerReader, TellsOtherFilesFromDamagedOnes) {
  expect_not_recognised({});
  expect_not_recognised(bytes_of("abc"));
  expect_not_recognised(bytes_of("\x89PNG\r\n and so on"));
  expect_not_recognised(ebml_head("other") + element(ids::kSegment, tracks()));
  expect_not_recognised(element(ids::kEbml, text(ids::kDocType, "matroska") + number(ids::kEbmlMaxIdLength, 5)));
  EXPECT_THROW(Reader(std::filesystem::path("/nowhere/at/all.mkv")), Error);
  EXPECT_THROW(Reader{std::filesystem::temp_directory_path()}, Error);
}

// A size that claims more than there is must not be believed, let alone allocated.
TEST(ContainerReader, AllocatesNothingForSizesThatTheFileDoesNotHave) {
  const Bytes huge = id_bytes(ids::kSimpleBlock) + big_endian((std::uint64_t{1} << 55) | std::uint64_t{1} << 56, 8);
  expect_corrupt(ebml_head() + unknown_size(ids::kSegment, tracks() + unknown_size(ids::kCluster, huge)), "cut short");
}

TEST(ContainerReader, GivesAFilesWholePayloadsBeforeItsCut) {
  const TemporaryFolder folder;
  const SampleFile sample = sample_file(11, 8, 60);
  write_sample(sample, folder / "a.mkv");
  const Bytes whole = load(folder / "a.mkv");
  std::size_t max_payloads = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    std::vector<Payload> payloads;
    try {
      Reader reader = open(cut);
      EXPECT_TRUE(reader.truncated()) << size;
      Payload payload;
      while (reader.next(payload)) payloads.push_back(payload);
      FAIL() << "a file cut at byte " << size << " was read without an error";
    } catch (const Error& error) {
      EXPECT_TRUE(error.code() == ErrorCode::kCorruptInput || size < 4) << size << ": " << error.what();
    }
    ASSERT_LE(payloads.size(), sample.payloads.size());
    for (std::size_t i = 0; i < payloads.size(); ++i) EXPECT_EQ(payloads[i].bytes, sample.payloads[i].bytes);
    EXPECT_GE(payloads.size(), max_payloads) << "fewer payloads from a longer file, cut at " << size;
    max_payloads = payloads.size();
  }
  EXPECT_EQ(max_payloads, sample.payloads.size());
}

// Whatever bit of a payload flips, its bytes, time, track and key flag are not believed.
TEST(ContainerReader, NoticesEveryFlippedBitOfAPayload) {
  const Bytes whole = frame();
  for (std::size_t bit = 0; bit < whole.size() * 8; ++bit) {
    Bytes damaged = whole;
    damaged[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    EXPECT_THROW(unwrap_payload(7, damaged, "memory.mkv: byte 0"), Error) << bit;
  }
}

TEST(ContainerReader, NeverGivesOtherPayloadsThanWereWrittenWhateverBitOfTheFileFlips) {
  const TemporaryFolder folder;
  const SampleFile sample = sample_file(12, 4, 40);
  write_sample(sample, folder / "a.mkv");
  const Bytes whole = load(folder / "a.mkv");
  for (std::size_t bit = 0; bit < whole.size() * 8; ++bit) {
    Bytes damaged = whole;
    damaged[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    try {
      Reader reader = open(damaged);
      Payload payload;
      while (reader.next(payload)) {
        const bool was_written = std::any_of(sample.payloads.begin(), sample.payloads.end(), [&](const Payload& p) {
          return p.track == payload.track && p.time_ns == payload.time_ns && p.key == payload.key &&
                 p.bytes == payload.bytes;
        });
        EXPECT_TRUE(was_written) << bit;
      }
    } catch (const Error&) {
      continue;
    }
  }
}

} // namespace
} // namespace kinora::container
