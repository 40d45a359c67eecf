#include "container/cue_index.h"

#include <algorithm>
#include <fstream>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "container/ebml.h"
#include "container/matroska_ids.h"
#include "container/reader.h"
#include "sample_file.h"

namespace kinora::container {
namespace {

constexpr std::size_t kHeadBytes = 4096;
constexpr int kPayloads = 200;
constexpr std::int64_t kStep = 40'000'000; // ns

/// Two tracks that take turns, every payload a key, in many clusters.
Bytes file_with_many_clusters() {
  const auto path = std::filesystem::path(::testing::TempDir()) / fmt::format("cue_index_{}.mkv", getpid());
  Random random(3);
  FileHead head;
  head.kind = "clip";
  head.tracks = {{1, "S_KINORA/POSES", "a", {}}, {2, "S_KINORA/POSES", "b", {}}};
  {
    Writer writer(path, head, {.cluster_bytes = 3000});
    for (int i = 0; i < kPayloads; ++i) {
      writer.write(static_cast<std::uint16_t>(1 + i % 2), i * kStep, true, testing::random_bytes(random, 500));
    }
    writer.finish();
  }
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  std::filesystem::remove(path);
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::optional<CueIndex> index_of(const Bytes& file) {
  MemorySource source(file, "memory.mkv");
  return CueIndex::read(std::span(file).first(std::min(file.size(), kHeadBytes)), source);
}

TEST(CueIndex, NamesTheBytesOfWhatIsShownAtATime) {
  const Bytes file = file_with_many_clusters();
  const auto index = index_of(file);
  ASSERT_TRUE(index);
  Reader reader(std::make_unique<MemorySource>(file, "memory.mkv"));
  const auto is_cluster = [&](std::uint64_t at) {
    MemorySource source(file, "memory.mkv");
    return read_element(source, at, file.size()).id == ids::kCluster;
  };
  std::size_t count = 0;
  for (Payload payload, before{}; reader.next(payload); before = payload, ++count) {
    const ByteRange range = index->bytes_for(static_cast<double>(payload.time_ns) * 1e-9);
    EXPECT_TRUE(range.begin <= payload.offset && payload.offset < range.end) << payload.time_ns;
    if (count > 0) { // the other track shows what it has shown since
      EXPECT_TRUE(range.begin <= before.offset && before.offset < range.end) << payload.time_ns;
    }
    EXPECT_TRUE(is_cluster(range.begin));
    EXPECT_TRUE(range.end == file.size() || is_cluster(range.end));
    EXPECT_LT(range.end - range.begin, 3 * 3000U + 2000) << "much more than is needed";
  }
  EXPECT_EQ(count, std::size_t{kPayloads});
  EXPECT_EQ(index->bytes_for(-5), index->bytes_for(0));
  EXPECT_EQ(index->bytes_for(1e9).end, file.size());
}

TEST(CueIndex, IsNoneWhereTheFileHasNone) {
  const Bytes file = file_with_many_clusters();
  EXPECT_FALSE(index_of({}));
  EXPECT_FALSE(index_of(Bytes(kHeadBytes, std::byte{7})));
  EXPECT_FALSE(index_of(Bytes(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(file.size() / 2)))); // cut
}

TEST(CueIndex, OfDamagedFilesIsNoneOrStaysInTheFile) {
  const Bytes file = file_with_many_clusters();
  Random random(11);
  int found = 0;
  for (int run = 0; run < 3000; ++run) {
    Bytes damaged = file;
    for (std::uint32_t n = 1 + random.below(3); n > 0; --n) {
      // In the head, or in the index, which is at the end.
      const std::size_t at =
          random.below(2) == 0 ? random.below(600) : file.size() - 1 - random.below(std::uint32_t{4096});
      damaged[at] ^= static_cast<std::byte>(1U << random.below(8));
    }
    const auto index = index_of(damaged);
    if (!index) continue;
    ++found;
    for (const double seconds : {-1.0, 0.0, 3.3, 8.0, 1e300}) {
      const ByteRange range = index->bytes_for(seconds);
      ASSERT_LE(range.begin, range.end);
      ASSERT_LE(range.end, file.size());
    }
  }
  EXPECT_GT(found, 100);
}

} // namespace
} // namespace kinora::container
