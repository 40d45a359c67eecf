// Claims about a clip whose file comes in pieces.
#include "clip/arriving_clip.h"

#include <array>

#include <gtest/gtest.h>

#include "clip/clip_io.h"
#include "container/ebml_builder.h"
#include "container/reader.h"
#include "sample_clip.h"

namespace kinora::clip {
namespace {

using container::Bytes;
using container::testing::load;
using container::testing::TemporaryFolder;

constexpr std::size_t kFrames = 5;

/// One whose frames are so far apart that each has a cluster of its own.
Clip slow_clip() {
  Clip clip = testing::sample_clip(3, kFrames, true);
  for (std::size_t f = 0; f < kFrames; ++f) clip.times[f] = 6.0 * static_cast<double>(f);
  return clip;
}

struct File {
  Bytes bytes;
  std::vector<std::size_t> first_payloads; ///< byte where the first of each frame starts
};
File file_of(const Clip& clip) {
  const TemporaryFolder folder;
  write_clip(clip, folder / "a.mkv");
  File file{load(folder / "a.mkv"), {}};
  container::Reader reader(folder / "a.mkv");
  container::Payload payload;
  std::int64_t time = -1;
  while (reader.next(payload)) {
    if (payload.time_ns == time) continue;
    time = payload.time_ns;
    file.first_payloads.push_back(static_cast<std::size_t>(payload.offset));
  }
  return file;
}

/// Of the cluster that holds a payload, which is its first.
std::size_t cluster_before(const Bytes& bytes, std::size_t payload) {
  constexpr std::array<unsigned, 4> kId{0x1F, 0x43, 0xB6, 0x75};
  std::size_t at = payload;
  const auto is_cluster = [&] {
    for (std::size_t i = 0; i < kId.size(); ++i) {
      if (std::to_integer<unsigned>(bytes[at + i]) != kId[i]) return false;
    }
    return true;
  };
  while (!is_cluster()) --at;
  return at;
}

Clip read_bytes_that_came(const Bytes& bytes, Arrival& arrival) {
  return read_arriving(std::make_unique<container::MemorySource>(bytes, "memory.mkv"), arrival);
}

TEST(ArrivingClip, SaysWhichFramesHaveComeAndHowManyThereAre) {
  const Clip clip = slow_clip();
  const File file = file_of(clip);
  ASSERT_EQ(file.first_payloads.size(), kFrames);
  const Bytes head(file.bytes.begin(), file.bytes.begin() + static_cast<std::ptrdiff_t>(file.first_payloads[2]));
  Arrival arrival;
  const Clip read = read_bytes_that_came(head, arrival);
  EXPECT_EQ(read.times.size(), 2U);
  EXPECT_EQ(arrival.times, clip.times);
  EXPECT_EQ(arrival.there, (std::vector{true, true, false, false, false}));
  EXPECT_EQ(arrival.layers, 2U);
}

TEST(ArrivingClip, ShowsALaterPieceBeforeWhatLiesBetweenHasCome) {
  const Clip clip = slow_clip();
  const File file = file_of(clip);
  ASSERT_EQ(file.first_payloads.size(), kFrames);
  const std::size_t last = cluster_before(file.bytes, file.first_payloads[4]);
  // The first piece ends in the middle of a payload.
  Bytes pieces(file.bytes.begin(), file.bytes.begin() + static_cast<std::ptrdiff_t>(file.first_payloads[2] + 20));
  pieces.insert(pieces.end(), file.bytes.begin() + static_cast<std::ptrdiff_t>(last), file.bytes.end());
  Arrival arrival;
  const Clip read = read_bytes_that_came(pieces, arrival);
  EXPECT_EQ(arrival.there, (std::vector{true, true, false, false, true}));
  ASSERT_EQ(read.times, clip.times);
  const Clip stored = as_stored(clip);
  for (const std::size_t frame : {0U, 1U, 4U}) {
    EXPECT_TRUE(read.layers[1].motion.poses()[frame].canonical_to_world.matrix() ==
                stored.layers[1].motion.poses()[frame].canonical_to_world.matrix())
        << frame;
    EXPECT_TRUE(read.camera_to_world[frame].matrix() == stored.camera_to_world[frame].matrix()) << frame;
  }
}

TEST(ArrivingClip, OfWhichAllHasComeLacksNothing) {
  Arrival arrival;
  read_bytes_that_came(file_of(slow_clip()).bytes, arrival);
  EXPECT_EQ(arrival.there, std::vector<bool>(kFrames, true));
  EXPECT_TRUE(arrival.missing.empty());
}

} // namespace
} // namespace kinora::clip
