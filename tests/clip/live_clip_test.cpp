// Clips that grow in a file: whoever reads it at any moment sees the last clip that was written whole.
#include "clip/live_clip_writer.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "clip/clip_io.h"
#include "clip/codec_ids.h"
#include "clip/payloads/field_codec.h"
#include "container/ebml_builder.h"
#include "container/reader.h"
#include "core/error.h"
#include "equal_clips.h"
#include "sample_clip.h"

namespace kinora::clip {
namespace {

using container::testing::load;
using container::testing::TemporaryFolder;

constexpr std::size_t kFrames = 40;

/// A bit more training: a few parameters move, and now and then a cell is opened or closed.
void train_a_bit(fields::Field& field, Random& random) {
  for (float& value : field.table) {
    if (random.below(8) == 0) value += static_cast<float>(0.03 * random.normal());
  }
  for (float& value : field.color_net) value += static_cast<float>(0.01 * random.normal());
  const auto r = static_cast<std::uint32_t>(field.config.occupancy_resolution);
  for (int i = 0; i < 5; ++i) {
    field.occupancy.set(static_cast<int>(random.below(r)), static_cast<int>(random.below(r)),
                        static_cast<int>(random.below(r)), random.below(2) == 0);
  }
}

motion::Motion first_frames(const motion::Motion& motion, std::size_t count) {
  const auto end = static_cast<std::ptrdiff_t>(count);
  if (motion.kind() == motion::MotionKind::kRigid)
    return motion::Motion::rigid({motion.poses().begin(), motion.poses().begin() + end});
  if (motion.kind() == motion::MotionKind::kDeforming)
    return motion::Motion::deforming(motion.graph(),
                                     {motion.deformations().begin(), motion.deformations().begin() + end});
  return motion;
}

/// As `whole` was when `frames` of it had come.
Clip so_far(const Clip& whole, std::size_t frames) {
  Clip clip = whole;
  clip.times.resize(frames);
  clip.capture_frames.resize(frames);
  clip.held_out.resize(frames);
  if (clip.camera_to_world.size() > 1) clip.camera_to_world.resize(frames);
  for (Layer& layer : clip.layers) {
    layer.motion = first_frames(layer.motion, frames);
    layer.joints.reset(); // are not known before the end
    layer.presence = motion::Presence::of_frames(layer.presence.in_frames(frames));
    layer.births = layer.births.in_first_frames(static_cast<std::uint32_t>(frames));
  }
  return clip;
}

/// The clips that a capture gives one after the other: the box comes late, the man gets another graph on the way, the
/// box leaves and comes again, and in the end the joints are there.
std::vector<Clip> growing_clips(std::uint64_t seed) {
  Random random(seed, 5);
  Clip whole = testing::bending_clip(seed, kFrames, seed % 2 == 1);
  whole.layers[1].presence = motion::Presence::away_during({{0, 9}, {kFrames - 5, kFrames}});
  const Clip other = testing::bending_clip(seed + 50, kFrames, false);
  std::vector<Clip> clips;
  for (std::size_t frames = 2; frames <= kFrames; frames += 3) {
    for (Layer& layer : whole.layers) {
      train_a_bit(layer.field, random);
      if (layer.confidence) layer.confidence = testing::random_confidence(layer.field.occupancy, frames);
    }
    if (clips.size() == 7) whole.layers[2].motion = other.layers[2].motion;
    whole.layers[2].births = testing::random_births(seed, whole.layers[2].motion.graph()->nodes().size(), kFrames);
    whole.metadata["round"] = frames;
    clips.push_back(so_far(whole, frames));
    const bool no_box = clips.size() < 3 || clips.size() == 9;
    if (no_box) clips.back().layers.erase(clips.back().layers.begin() + 1);
  }
  clips.push_back(whole);
  return clips;
}

TEST(LiveClip, IsAtAnyMomentTheClipThatWasWrittenLast) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    SCOPED_TRACE(seed);
    const std::vector<Clip> clips = growing_clips(seed);
    LiveClipWriter writer(folder / "a.mkv", clips.front().intrinsics);
    for (const Clip& clip : clips) {
      writer.write(clip);
      testing::expect_equal(read_clip(folder / "a.mkv"), as_stored(clip));
      if (::testing::Test::HasFailure()) FAIL() << "after " << clip.times.size() << " frames";
    }
    writer.finish();
    testing::expect_equal(read_clip(folder / "a.mkv"), as_stored(clips.back()));
  }
}

/// Whether each update of the file is a key update, and its bytes.
std::vector<std::pair<bool, std::size_t>> updates_in(const std::filesystem::path& path) {
  container::Reader reader(path, container::Reading::kFollow);
  container::Payload payload;
  std::vector<std::pair<bool, std::size_t>> updates;
  while (reader.next(payload)) updates.emplace_back(payload.key, payload.bytes.size());
  return updates;
}

TEST(LiveClip, TellsLittleMoreThanWhatHasChanged) {
  const TemporaryFolder folder;
  const std::vector<Clip> clips = growing_clips(4);
  {
    LiveClipWriter writer(folder / "a.mkv", clips.front().intrinsics);
    Clip clip = clips.back();
    for (int i = 0; i < 30; ++i) {
      if (i > 0) clip.layers[0].field.table[0] += 1e-3F;
      writer.write(clip);
    }
  }
  const auto updates = updates_in(folder / "a.mkv");
  ASSERT_EQ(updates.size(), 30U);
  EXPECT_TRUE(updates[0].first);
  EXPECT_FALSE(updates[1].first);
  EXPECT_LT(updates[1].second, updates[0].second / 3);
  const auto keys = std::count_if(updates.begin(), updates.end(), [](const auto& update) { return update.first; });
  EXPECT_GT(keys, 1); // late viewers need not go back to the first
}

TEST(LiveClip, OfEveryPrefixGivesTheLastUpdateThatIsWhole) {
  const TemporaryFolder folder;
  const std::vector<Clip> clips = growing_clips(5);
  std::vector<std::size_t> sizes; // of the file after each
  {
    LiveClipWriter writer(folder / "a.mkv", clips.front().intrinsics);
    for (const Clip& clip : clips) {
      writer.write(clip);
      sizes.push_back(std::filesystem::file_size(folder / "a.mkv"));
    }
  }
  std::vector<Clip> stored;
  stored.reserve(clips.size());
  for (const Clip& clip : clips) stored.push_back(as_stored(clip));
  const Bytes bytes = load(folder / "a.mkv");
  Random random(6);
  for (std::size_t size = 0; size < bytes.size();
       size += 1 + random.below(static_cast<std::uint32_t>(bytes.size() / 60))) {
    SCOPED_TRACE(size);
    const auto whole = std::count_if(sizes.begin(), sizes.end(), [&](std::size_t end) { return end <= size; });
    const auto open = [&] {
      return std::make_unique<container::MemorySource>(std::span(bytes).first(size), "cut.mkv");
    };
    if (whole == 0) {
      EXPECT_THROW(read_clip(open()), Error);
      continue;
    }
    testing::expect_equal(read_clip(open()), stored[static_cast<std::size_t>(whole) - 1]);
    std::vector<std::string> missing;
    testing::expect_equal(read_whole_parts(open(), missing), stored[static_cast<std::size_t>(whole) - 1]);
  }
}

TEST(LiveClip, WithAFlippedBitIsNeverAnotherThanOneThatWasWritten) {
  const TemporaryFolder folder;
  const std::vector<Clip> clips = growing_clips(7);
  {
    LiveClipWriter writer(folder / "a.mkv", clips.front().intrinsics);
    for (const Clip& clip : clips) writer.write(clip);
    writer.finish();
  }
  Bytes bytes = load(folder / "a.mkv");
  std::vector<fields::Field> fields;
  fields.reserve(clips.size());
  for (const Clip& clip : clips) fields.push_back(quantised(clip.layers.front().field));
  Random random(8);
  int given = 0;
  for (int i = 0; i < 200; ++i) {
    const std::size_t at = random.below(static_cast<std::uint32_t>(bytes.size()));
    const auto bit = static_cast<std::byte>(1U << random.below(8));
    bytes[at] ^= bit;
    std::vector<std::string> missing;
    try {
      const Clip clip = read_whole_parts(
          std::make_unique<container::MemorySource>(std::span<const std::byte>(bytes), "a.mkv"), missing);
      ++given;
      const auto same = [&](const fields::Field& field) {
        return field.table == clip.layers.front().field.table && field.color_net == clip.layers.front().field.color_net;
      };
      EXPECT_TRUE(std::any_of(fields.begin(), fields.end(), same)) << "byte " << at;
    } catch (const Error& error) {
      EXPECT_TRUE(error.code() == ErrorCode::kCorruptInput || error.code() == ErrorCode::kNotRecognised)
          << error.what();
    }
    bytes[at] ^= bit;
  }
  EXPECT_GT(given, 150); // one damaged update costs no other
}

TEST(LiveClip, SaysThatADiskIsFull) {
  const Clip clip = testing::sample_clip(9, 3, false);
  try {
    LiveClipWriter writer("/dev/full", clip.intrinsics);
    writer.write(clip);
    FAIL() << "was written";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUnwritableOutput);
  }
}

} // namespace
} // namespace kinora::clip
