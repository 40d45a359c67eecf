// Mutated Kinora files: the reader may refuse them, and must do nothing worse.
#include <gtest/gtest.h>

#include "container/ebml_builder.h"
#include "container/sample_file.h"
#include "core/error.h"
#include "fuzz/mutate.h"

namespace kinora::container {
namespace {

using namespace testing;

void expect_survives(const Bytes& file) {
  try {
    Reader reader = open(file);
    for (const StoredAttachment& attachment : reader.attachments()) reader.read_attachment(attachment);
    read_all(reader);
  } catch (const Error& error) {
    EXPECT_TRUE(error.code() == ErrorCode::kCorruptInput || error.code() == ErrorCode::kNotRecognised) << error.what();
  }
}

TEST(ContainerFuzz, ReaderRefusesOrReadsMutatedFiles) {
  const TemporaryFolder folder;
  std::vector<Bytes> seeds;
  for (std::uint64_t seed = 31; seed < 35; ++seed) {
    write_sample(sample_file(seed, 12, 200), folder / "a.mkv");
    seeds.push_back(load(folder / "a.mkv"));
  }
  for (std::uint64_t i = 0; i < 4000; ++i) {
    Random random(99, i);
    expect_survives(fuzz::mutate(seeds[i % seeds.size()], random));
    if (::testing::Test::HasFailure()) FAIL() << "at mutation " << i;
  }
}

TEST(ContainerFuzz, ReaderRefusesOrReadsMutatedFilesOfUnknownSizes) {
  const Bytes frame = wrap_payload(7, 5, true, bytes_of("hello"));
  const Bytes cluster = unknown_size(ids::kCluster, simple_block(1, frame));
  const Bytes seed =
      ebml_head() + unknown_size(ids::kSegment, element(ids::kTracks, track_entry(1, 7)) + cluster + cluster);
  for (std::uint64_t i = 0; i < 4000; ++i) {
    Random random(100, i);
    expect_survives(fuzz::mutate(seed, random));
    if (::testing::Test::HasFailure()) FAIL() << "at mutation " << i;
  }
}

} // namespace
} // namespace kinora::container
