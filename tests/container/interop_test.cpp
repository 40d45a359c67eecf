// Our files in the hands of others: libmatroska as an oracle, mkvmerge, mkvinfo and ffprobe.
#include <cstdlib>

#include <ebml/EbmlHead.h>
#include <ebml/EbmlStream.h>
#include <ebml/StdIOCallback.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <matroska/KaxBlock.h>
#include <matroska/KaxCluster.h>
#include <matroska/KaxClusterData.h>
#include <matroska/KaxCues.h>
#include <matroska/KaxCuesData.h>
#include <matroska/KaxSegment.h>
#include <matroska/KaxTrackEntryData.h>
#include <matroska/KaxTracks.h>

#include "ebml_builder.h"
#include "sample_file.h"

namespace kinora::container {
namespace {

using testing::read_all;
using testing::sample_file;
using testing::SampleFile;
using testing::TemporaryFolder;
using testing::write_sample;

struct OracleBlock {
  std::uint64_t track_number;
  std::uint64_t time; // milliseconds
  Bytes frame;
};

struct Oracle {
  std::vector<std::string> codecs;
  std::vector<OracleBlock> blocks;
  std::size_t cues_that_point_at_their_block = 0;
  std::size_t cues = 0;
};

// Everything that libmatroska finds in a file.
Oracle read_with_libmatroska(const std::filesystem::path& path) {
  using namespace libebml;
  using namespace libmatroska;
  Oracle oracle;
  StdIOCallback file(path.c_str(), MODE_READ);
  EbmlStream stream(file);
  std::unique_ptr<EbmlElement> head(stream.FindNextID(EBML_INFO(EbmlHead), ~0ULL));
  head->SkipData(stream, EBML_CONTEXT(head));
  std::unique_ptr<EbmlElement> segment(stream.FindNextID(EBML_INFO(KaxSegment), ~0ULL));
  const std::uint64_t segment_start = static_cast<KaxSegment&>(*segment).GetDataStart();
  std::vector<std::uint64_t> block_positions;
  int upper = 0;
  for (;;) {
    std::unique_ptr<EbmlElement> element(
        stream.FindNextElement(EBML_CONTEXT(segment), upper, segment->GetSize(), true));
    if (!element || upper > 0) break;
    EbmlElement* found = nullptr;
    if (!EbmlId(*element).operator==(EBML_ID(KaxTracks)) && EbmlId(*element) != EBML_ID(KaxCluster) &&
        EbmlId(*element) != EBML_ID(KaxCues)) {
      element->SkipData(stream, EBML_CONTEXT(element));
      continue;
    }
    auto& master = static_cast<EbmlMaster&>(*element);
    master.Read(stream, EBML_CONTEXT(element), upper, found, true);
    if (EbmlId(*element) == EBML_ID(KaxCluster)) {
      auto& cluster = static_cast<KaxCluster&>(master);
      const std::uint64_t start = static_cast<std::uint64_t>(GetChild<KaxClusterTimecode>(cluster));
      for (EbmlElement* child : master) {
        if (EbmlId(*child) != EBML_ID(KaxSimpleBlock)) continue;
        auto& block = static_cast<KaxSimpleBlock&>(*child);
        EXPECT_EQ(block.NumberFrames(), 1U);
        const DataBuffer& data = block.GetBuffer(0);
        const auto* const first = reinterpret_cast<const std::byte*>(const_cast<DataBuffer&>(data).Buffer());
        oracle.blocks.push_back({block.TrackNum(), start + static_cast<std::uint64_t>(block.GetRelativeTimestamp()),
                                 Bytes(first, first + data.Size())});
        block_positions.push_back(block.GetElementPosition());
      }
    } else {
      for (EbmlElement* child : master) {
        if (EbmlId(*child) == EBML_ID(KaxTrackEntry)) {
          oracle.codecs.push_back(GetChild<KaxCodecID>(static_cast<EbmlMaster&>(*child)).GetValue());
        } else if (EbmlId(*child) == EBML_ID(KaxCuePoint)) {
          auto& positions = GetChild<KaxCueTrackPositions>(static_cast<EbmlMaster&>(*child));
          // An element's position in a cluster counts from the cluster's first byte of data: 4 bytes of identifier and
          // the size before it.
          const std::uint64_t cluster = static_cast<std::uint64_t>(GetChild<KaxCueClusterPosition>(positions));
          const std::uint64_t relative = static_cast<std::uint64_t>(GetChild<KaxCueRelativePosition>(positions));
          FileSource source(path);
          const Element there = read_element(source, segment_start + cluster, source.size());
          ++oracle.cues;
          if (std::count(block_positions.begin(), block_positions.end(), there.body + relative) == 1) {
            ++oracle.cues_that_point_at_their_block;
          }
        }
      }
    }
  }
  return oracle;
}

TEST(ContainerInterop, LibmatroskaReadsTheTracksTimesAndBytesThatWereWritten) {
  const TemporaryFolder folder;
  const SampleFile sample = sample_file(21, 60, 100'000);
  write_sample(sample, folder / "a.mkv");
  const Oracle oracle = read_with_libmatroska(folder / "a.mkv");
  ASSERT_EQ(oracle.codecs.size(), sample.head.tracks.size());
  for (std::size_t i = 0; i < oracle.codecs.size(); ++i) EXPECT_EQ(oracle.codecs[i], sample.head.tracks[i].codec);
  ASSERT_EQ(oracle.blocks.size(), sample.payloads.size());
  for (std::size_t i = 0; i < oracle.blocks.size(); ++i) {
    const Payload& payload = sample.payloads[i];
    ASSERT_GE(oracle.blocks[i].track_number, 1U);
    EXPECT_EQ(sample.head.tracks[oracle.blocks[i].track_number - 1].id, payload.track);
    EXPECT_EQ(oracle.blocks[i].time, static_cast<std::uint64_t>(payload.time_ns + 500'000) / 1'000'000);
    EXPECT_EQ(oracle.blocks[i].frame, wrap_payload(payload.track, payload.time_ns, payload.key, payload.bytes));
  }
}

TEST(ContainerInterop, CuesPointAtBlocks) {
  const TemporaryFolder folder;
  write_sample(sample_file(22, 200, 20'000), folder / "a.mkv");
  const Oracle oracle = read_with_libmatroska(folder / "a.mkv");
  EXPECT_GT(oracle.cues, 2U);
  EXPECT_EQ(oracle.cues_that_point_at_their_block, oracle.cues);
}

int run(const std::string& command) { return std::system(command.c_str()); }
bool is_installed(const std::string& tool) { return run("command -v " + tool + " > /dev/null 2>&1") == 0; }

TEST(ContainerInterop, SurvivesRemuxingByMkvmerge) {
  if (!is_installed("mkvmerge")) GTEST_SKIP() << "mkvmerge is not installed";
  const TemporaryFolder folder;
  for (std::uint64_t seed = 23; seed < 26; ++seed) {
    const SampleFile sample = sample_file(seed, 100, 50'000);
    write_sample(sample, folder / "a.mkv");
    const std::string a = (folder / "a.mkv").string();
    const std::string b = (folder / "b.mkv").string();
    ASSERT_EQ(run(fmt::format("mkvmerge -q -o {} {}", b, a)), 0);
    Reader reader(b);
    EXPECT_EQ(reader.tag(kKindTag), "clip");
    EXPECT_EQ(reader.tracks().size(), sample.head.tracks.size());
    EXPECT_EQ(reader.chapters(), sample.head.chapters);
    ASSERT_EQ(reader.attachments().size(), sample.head.attachments.size());
    for (std::size_t i = 0; i < sample.head.attachments.size(); ++i) {
      EXPECT_TRUE(reader.attachments()[i].checksum.has_value());
      EXPECT_EQ(reader.read_attachment(reader.attachments()[i]), sample.head.attachments[i].bytes);
    }
    // Payloads of one track stay in order; tracks may be interleaved anew.
    const std::vector<Payload> payloads = read_all(reader);
    ASSERT_EQ(payloads.size(), sample.payloads.size());
    for (const Track& track : sample.head.tracks) {
      std::vector<const Payload*> written;
      std::vector<const Payload*> kept;
      for (const Payload& p : sample.payloads) {
        if (p.track == track.id) written.push_back(&p);
      }
      for (const Payload& p : payloads) {
        if (p.track == track.id) kept.push_back(&p);
      }
      ASSERT_EQ(written.size(), kept.size());
      for (std::size_t i = 0; i < kept.size(); ++i) {
        EXPECT_EQ(kept[i]->time_ns, written[i]->time_ns);
        EXPECT_EQ(kept[i]->key, written[i]->key);
        EXPECT_EQ(kept[i]->bytes, written[i]->bytes);
      }
    }
  }
}

TEST(ContainerInterop, MkvinfoAndFfprobeListEveryTrack) {
  if (!is_installed("mkvinfo") || !is_installed("ffprobe")) GTEST_SKIP() << "mkvinfo and ffprobe are not installed";
  const TemporaryFolder folder;
  const SampleFile sample = sample_file(27, 20, 2000);
  write_sample(sample, folder / "a.mkv");
  const std::string a = (folder / "a.mkv").string();
  const std::string log = (folder / "log").string();
  EXPECT_EQ(run(fmt::format("LC_ALL=C.UTF-8 mkvinfo {} > {}", a, log)), 0);
  EXPECT_EQ(run(fmt::format("ffprobe -hide_banner {} >> {} 2>&1", a, log)), 0);
  const Bytes bytes = testing::load(log);
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (const Track& track : sample.head.tracks) {
    EXPECT_NE(text.find("Name: " + track.name), std::string::npos) << "mkvinfo lists no " << track.name;
    EXPECT_NE(text.find("title           : " + track.name), std::string::npos) << "ffprobe lists no " << track.name;
  }
}

} // namespace
} // namespace kinora::container
