// Claims about what is read of files that are damaged, cut, or not finished.
#include <algorithm>
#include <csignal>
#include <fstream>

#include <sys/resource.h>

#include <gtest/gtest.h>

#include "container/envelope.h"
#include "core/error.h"
#include "ebml_builder.h"
#include "fuzz/mutate.h"
#include "sample_file.h"

namespace kinora::container {
namespace {

using namespace testing;

Reader salvage(const Bytes& file) {
  return Reader(std::make_unique<MemorySource>(file, "memory.mkv"), Reading::kSalvage);
}

bool equal(const Payload& a, const Payload& b) {
  return a.track == b.track && a.time_ns == b.time_ns && a.key == b.key && a.bytes == b.bytes;
}

struct WrittenFile {
  Bytes bytes;
  std::vector<Payload> payloads;   ///< with the places where they stand
  std::uint64_t first_payload = 0; ///< byte where the first begins
};

WrittenFile written(std::uint64_t seed, std::size_t count, std::size_t largest) {
  const TemporaryFolder folder;
  write_sample(sample_file(seed, count, largest), folder / "a.mkv");
  WrittenFile file;
  file.bytes = load(folder / "a.mkv");
  Reader reader = open(file.bytes);
  file.payloads = read_all(reader);
  if (!file.payloads.empty()) file.first_payload = file.payloads.front().offset;
  return file;
}

TEST(Reader, PassesOverWhatIsLargerThanItsLimit) {
  const WrittenFile file = written(4, 40, 900);
  const auto is_small = [](const Payload& payload) { return payload.bytes.size() < 500; };
  ASSERT_TRUE(std::any_of(file.payloads.begin(), file.payloads.end(), std::not_fn(is_small)));
  Reader strict = open(file.bytes);
  strict.limit_payloads(499 + kEnvelopeBytes);
  EXPECT_THROW(read_all(strict), Error);
  Reader reader = salvage(file.bytes);
  reader.limit_payloads(499 + kEnvelopeBytes);
  const std::vector<Payload> given = read_all(reader);
  std::vector<Payload> small;
  std::copy_if(file.payloads.begin(), file.payloads.end(), std::back_inserter(small), is_small);
  EXPECT_TRUE(std::equal(given.begin(), given.end(), small.begin(), small.end(), equal));
  EXPECT_FALSE(reader.damage().empty());
}

/// All of `given` were written, in this order; says how many of the others could have been read.
std::size_t missing_untouched(const WrittenFile& file, const std::vector<Payload>& given, std::uint64_t from,
                              std::uint64_t to) {
  std::size_t missing = 0;
  std::size_t at = 0;
  for (const Payload& payload : file.payloads) {
    if (at < given.size() && given[at].offset == payload.offset && equal(given[at], payload)) {
      ++at;
      continue;
    }
    const bool touched = payload.offset < to && payload.offset + payload.stored_bytes > from;
    missing += touched ? 0 : 1;
  }
  EXPECT_EQ(at, given.size()) << "a payload that was never written, or out of order";
  return missing;
}

TEST(ContainerSalvage, GivesEveryPayloadThatDamageDidNotTouch) {
  const WrittenFile file = written(21, 60, 3000);
  for (std::uint64_t i = 0; i < 600; ++i) {
    Random random(7, i);
    const auto room = static_cast<std::uint32_t>(file.bytes.size() - file.first_payload);
    const std::uint64_t from = file.first_payload + random.below(room);
    const std::uint64_t to =
        std::min<std::uint64_t>(from + 1 + random.below(i % 2 == 0 ? 20 : 6000), file.bytes.size());
    Bytes damaged = file.bytes;
    const bool zeros = random.below(3) == 0;
    for (std::uint64_t b = from; b < to; ++b)
      damaged[b] = zeros ? std::byte{0} : static_cast<std::byte>(random.below(256));
    Reader reader = salvage(damaged);
    const std::vector<Payload> given = read_all(reader);
    EXPECT_EQ(missing_untouched(file, given, from, to), 0U) << "damage from " << from << " to " << to;
    if (given.size() < file.payloads.size()) {
      ASSERT_FALSE(reader.damage().empty()) << i;
      const Damage& damage = reader.damage().entries().front();
      EXPECT_LE(damage.offset, to) << i;
      EXPECT_GE(reader.damage().entries().back().end, from) << i;
      EXPECT_EQ(damage.why.rfind("memory.mkv: byte ", 0), 0U) << damage.why;
    }
  }
}

TEST(ContainerSalvage, GoesOnBehindBytesThatAreMissing) {
  const WrittenFile file = written(22, 60, 3000);
  for (std::uint64_t i = 0; i < 200; ++i) {
    Random random(8, i);
    const auto room = static_cast<std::uint32_t>(file.bytes.size() - file.first_payload - 1);
    const std::uint64_t from = file.first_payload + random.below(room);
    const std::uint64_t count =
        1 + random.below(static_cast<std::uint32_t>(std::min<std::uint64_t>(4000, file.bytes.size() - from - 1)));
    Bytes cut = file.bytes;
    cut.erase(cut.begin() + static_cast<std::ptrdiff_t>(from), cut.begin() + static_cast<std::ptrdiff_t>(from + count));
    Reader reader = salvage(cut);
    std::vector<Payload> given = read_all(reader);
    for (Payload& payload : given) payload.offset += payload.offset >= from ? count : 0;
    EXPECT_EQ(missing_untouched(file, given, from, from + count), 0U) << "missing from " << from << ", " << count;
  }
}

TEST(ContainerSalvage, GivesAllThatStandsBeforeACutAndSaysWhereItIs) {
  const WrittenFile file = written(23, 8, 60);
  for (std::size_t size = file.first_payload; size < file.bytes.size(); ++size) {
    const Bytes cut(file.bytes.begin(), file.bytes.begin() + static_cast<std::ptrdiff_t>(size));
    Reader reader = salvage(cut);
    const std::vector<Payload> given = read_all(reader);
    EXPECT_EQ(missing_untouched(file, given, size, file.bytes.size()), 0U) << size;
    EXPECT_TRUE(reader.truncated()) << size;
    EXPECT_FALSE(reader.finished()) << size;
  }
}

TEST(ContainerSalvage, FindsNoFaultInSoundFiles) {
  for (std::uint64_t seed = 40; seed < 50; ++seed) {
    const WrittenFile file = written(seed, seed - 40, 4000);
    Reader reader = salvage(file.bytes);
    EXPECT_EQ(read_all(reader).size(), file.payloads.size());
    EXPECT_TRUE(reader.damage().empty()) << reader.damage().entries().front().why;
    EXPECT_TRUE(reader.finished());
  }
}

TEST(ContainerSalvage, PassesOverElementsThatItDoesNotKnowWithoutCallingThemDamage) {
  const Bytes noise = element(0xEC, Bytes(30)) + element(0x1ABCDEF0, Bytes(9));
  const Bytes block = simple_block(1, wrap_payload(7, 5, true, bytes_of("hello")));
  const Bytes file =
      ebml_head() + element(ids::kSegment, noise + element(ids::kTracks, track_entry(1, 7)) + noise +
                                               element(ids::kCluster, number(0xE7, 0) + noise + block + noise + block));
  Reader reader = salvage(file);
  EXPECT_EQ(read_all(reader).size(), 2U);
  EXPECT_TRUE(reader.damage().empty()) << reader.damage().entries().front().why;
}

TEST(ContainerSalvage, NeverGivesPayloadsThatWereNotWrittenAndAlwaysEnds) {
  std::vector<WrittenFile> files;
  for (std::uint64_t seed = 31; seed < 34; ++seed) files.push_back(written(seed, 12, 200));
  for (std::uint64_t i = 0; i < 3000; ++i) {
    Random random(101, i);
    const WrittenFile& file = files[i % files.size()];
    const Bytes damaged = fuzz::mutate(file.bytes, random);
    try {
      Reader reader = salvage(damaged);
      for (const Payload& payload : read_all(reader)) {
        EXPECT_TRUE(std::any_of(file.payloads.begin(), file.payloads.end(), [&](const Payload& p) {
          return equal(p, payload);
        })) << i;
      }
    } catch (const Error& error) { // of a head that cannot be understood
      EXPECT_TRUE(error.code() == ErrorCode::kCorruptInput || error.code() == ErrorCode::kNotRecognised)
          << error.what();
    }
    if (::testing::Test::HasFailure()) FAIL() << "at mutation " << i;
  }
}

void append(const std::filesystem::path& path, const Bytes& bytes, std::size_t from, std::size_t to) {
  std::ofstream file(path, std::ios::binary | std::ios::app);
  file.write(reinterpret_cast<const char*>(bytes.data() + from), static_cast<std::streamsize>(to - from));
}

TEST(ContainerFollow, GivesEachPayloadAsSoonAsItIsThere) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 60; seed < 64; ++seed) {
    const WrittenFile file = written(seed, 30, 2000);
    const std::filesystem::path path = folder / "growing.mkv";
    std::filesystem::remove(path);
    std::size_t size = file.first_payload;
    append(path, file.bytes, 0, size);
    Reader reader(path, Reading::kFollow);
    Random random(9, seed);
    std::vector<Payload> given;
    while (true) {
      Payload payload;
      while (reader.next(payload)) given.push_back(payload);
      const auto whole = std::count_if(file.payloads.begin(), file.payloads.end(),
                                       [&](const Payload& p) { return p.offset + p.stored_bytes <= size; });
      ASSERT_EQ(given.size(), static_cast<std::size_t>(whole)) << "at " << size;
      EXPECT_EQ(reader.finished(), size == file.bytes.size());
      if (size == file.bytes.size()) break;
      const std::size_t next = std::min(file.bytes.size(), size + 1 + random.below(1500));
      append(path, file.bytes, size, next);
      size = next;
      reader.refresh();
    }
    EXPECT_EQ(missing_untouched(file, given, 0, 0), 0U);
  }
}

TEST(ContainerFollow, StartsALateViewerAtTheLastKeyPayloadOfATrack) {
  const WrittenFile file = written(66, 40, 500);
  const std::uint16_t track = file.payloads.back().track;
  std::size_t last = file.payloads.size();
  for (std::size_t i = 0; i < file.payloads.size(); ++i)
    if (file.payloads[i].track == track && file.payloads[i].key) last = i;
  ASSERT_LT(last, file.payloads.size());
  Reader reader(std::make_unique<MemorySource>(file.bytes, "memory.mkv"), Reading::kFollow);
  reader.skip_to_last_key(track);
  const std::vector<Payload> given = read_all(reader);
  ASSERT_EQ(given.size(), file.payloads.size() - last);
  EXPECT_TRUE(equal(given.front(), file.payloads[last]));
}

TEST(ContainerFollow, ReadsAFileUpToWhatItsWriterHasFlushed) {
  const TemporaryFolder folder;
  const SampleFile sample = sample_file(67, 40, 3000);
  WriterOptions options;
  options.cluster_bytes = 10'000;
  Writer writer(folder / "a.mkv", sample.head, options);
  Reader reader(folder / "a.mkv", Reading::kFollow);
  std::size_t given = 0;
  Payload payload;
  for (std::size_t i = 0; i < sample.payloads.size(); ++i) {
    const Payload& p = sample.payloads[i];
    writer.write(p.track, p.time_ns, p.key, p.bytes);
    if (i % 7 == 0) writer.flush();
    reader.refresh();
    while (reader.next(payload)) EXPECT_TRUE(equal(payload, sample.payloads[given++]));
    if (i % 7 == 0) {
      EXPECT_EQ(given, i + 1);
    }
    EXPECT_FALSE(reader.finished());
  }
  writer.finish();
  reader.refresh();
  while (reader.next(payload)) EXPECT_TRUE(equal(payload, sample.payloads[given++]));
  EXPECT_EQ(given, sample.payloads.size());
  EXPECT_TRUE(reader.finished());
}

/// Files of this process cannot grow beyond so many bytes, as on a disk that is full, while this lives.
class FileSizeLimit {
public:
  explicit FileSizeLimit(std::size_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

private:
  rlimit before_{};
  void (*handler_)(int) = SIG_DFL;
};

TEST(ContainerWriter, CompletesAFileUpToItsLastWholeClusterWhereTheDiskIsFull) {
  const TemporaryFolder folder;
  const SampleFile sample = sample_file(68, 60, 3000);
  WriterOptions options;
  options.cluster_bytes = 10'000;
  std::size_t most = 0;
  for (std::size_t limit = 12'000; limit < 80'000; limit += 1777) {
    SCOPED_TRACE(limit);
    {
      const FileSizeLimit full(limit);
      Writer writer(folder / "a.mkv", sample.head, options);
      try {
        for (const Payload& p : sample.payloads) writer.write(p.track, p.time_ns, p.key, p.bytes);
        writer.finish();
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kUnwritableOutput) << error.what();
        writer.finish_at_last_cluster();
      }
    }
    Reader reader(folder / "a.mkv");
    const std::vector<Payload> given = read_all(reader);
    EXPECT_TRUE(reader.finished());
    ASSERT_LE(given.size(), sample.payloads.size());
    for (std::size_t i = 0; i < given.size(); ++i) EXPECT_TRUE(equal(given[i], sample.payloads[i])) << i;
    EXPECT_GE(given.size(), most);
    EXPECT_LE(reader.file_bytes(), limit);
    most = given.size();
  }
  EXPECT_GT(most, 20U);
}

TEST(ContainerRoundTrip, KeepsBlocksOfCodecsThatOthersKnowAsTheyAre) {
  const TemporaryFolder folder;
  Track video{9, "V_MJPEG", "colour", bytes_of("private")};
  video.media = MediaFormat{64, 48};
  {
    Writer writer(folder / "a.mkv", {"recording", {{7, "S_KINORA/FRAMES", "", {}}, video}, {}, {}, 0});
    writer.write(9, 40'000'000, true, bytes_of("picture"));
    writer.write(7, 40'000'001, true, bytes_of("payload"));
    writer.finish();
  }
  Reader reader(folder / "a.mkv");
  ASSERT_EQ(reader.tracks().size(), 2U);
  EXPECT_EQ(reader.tracks()[1].type, 1U);
  EXPECT_EQ(reader.tracks()[1].track.private_data, bytes_of("private"));
  StoredBlock block;
  ASSERT_TRUE(reader.next_block(block));
  EXPECT_EQ(block.track, 1U);
  EXPECT_EQ(block.time_ns, 40'000'000);
  EXPECT_EQ(reader.read_block(block), bytes_of("picture"));
  ASSERT_TRUE(reader.next_block(block));
  EXPECT_EQ(reader.read_payload(block).time_ns, 40'000'001);
  EXPECT_FALSE(reader.next_block(block));
}

} // namespace
} // namespace kinora::container
