// Claims about what is read of a clip whose file is cut or damaged: what is whole, and word of what is not.
#include <algorithm>

#include <gtest/gtest.h>

#include "clip/clip_io.h"
#include "clip/codec_ids.h"
#include "clip/missing_parts.h"
#include "container/ebml_builder.h"
#include "container/reader.h"
#include "container/writer.h"
#include "core/error.h"
#include "equal_clips.h"
#include "sample_clip.h"

namespace kinora::clip {
namespace {

using container::Bytes;
using container::testing::load;
using container::testing::TemporaryFolder;

constexpr std::size_t kFrames = 5;

/// A still, a rigid and a deforming layer, a moving camera, confidence and joints, in few bytes.
Clip small_clip() {
  fields::FieldConfig config = testing::small_config();
  config.levels = 2;
  config.log2_table_size = 4;
  config.finest_resolution = 12;
  Clip clip = testing::sample_clip(3, kFrames, true);
  for (std::size_t l = 0; l < clip.layers.size(); ++l) clip.layers[l].field = testing::random_field(l, config);
  clip.layers[0].confidence = testing::random_confidence(clip.layers[0].field.occupancy, 1);
  testing::WalkerOptions walker;
  walker.nodes = 8;
  walker.frames = kFrames;
  clip.layers.push_back({"person", 1, testing::random_field(7, config), testing::walker(walker)});
  clip.layers.back().joints = testing::random_joints(1, kFrames);
  clip.layers[1].presence = motion::Presence::away_during({{0, 1}, {2, kFrames}});
  clip.layers[2].births = motion::NodeBirths({0, 0, 1, 2, 3, 4, 5, 0});
  return clip;
}

Bytes file_of(const Clip& clip) {
  const TemporaryFolder folder;
  write_clip(clip, folder / "a.mkv");
  return load(folder / "a.mkv");
}

TEST(DamagedClip, WithAPayloadLargerThanAnyIsRefusedOrReadWithoutIt) {
  const TemporaryFolder folder;
  write_clip(small_clip(), folder / "a.mkv");
  container::Reader reader(folder / "a.mkv");
  container::FileHead head;
  head.kind = std::string(kClipKind);
  for (const container::StoredTrack& track : reader.tracks()) head.tracks.push_back(track.track);
  for (const container::StoredAttachment& attachment : reader.attachments())
    head.attachments.push_back(
        {attachment.name, attachment.media_type, attachment.description, reader.read_attachment(attachment)});
  {
    container::Writer writer(folder / "b.mkv", head);
    for (container::Payload payload; reader.next(payload);)
      writer.write(payload.track, payload.time_ns, payload.key, payload.bytes);
    writer.write(head.tracks.front().id, 1'000'000'000, false, Bytes(kMaxPayloadBytes));
    writer.finish();
  }
  EXPECT_THROW(read_clip(folder / "b.mkv"), Error);
  std::vector<std::string> missing;
  const Clip clip = read_whole_parts(std::make_unique<container::FileSource>(folder / "b.mkv"), missing);
  EXPECT_EQ(clip.layers.size(), small_clip().layers.size());
  EXPECT_EQ(missing.size(), 1U);
}

struct Outcome {
  std::optional<Clip> clip; ///< or an error
  std::vector<std::string> missing;
};

Outcome read_parts(const Bytes& bytes) {
  Outcome outcome;
  try {
    outcome.clip = read_whole_parts(std::make_unique<container::MemorySource>(bytes, "memory.mkv"), outcome.missing);
  } catch (const Error& error) {
    EXPECT_TRUE(error.code() == ErrorCode::kCorruptInput || error.code() == ErrorCode::kNotRecognised) << error.what();
    EXPECT_NE(std::string(error.what()).find("memory.mkv"), std::string::npos) << error.what();
  }
  return outcome;
}

bool same_transform(const DualQuaternion& a, const DualQuaternion& b) {
  return a.real.coeffs() == b.real.coeffs() && a.dual.coeffs() == b.dual.coeffs();
}
bool same_place(const motion::Motion& a, std::size_t i, const motion::Motion& b, std::size_t j) {
  if (a.kind() == motion::MotionKind::kRigid)
    return a.poses()[i].canonical_to_world.matrix() == b.poses()[j].canonical_to_world.matrix();
  return std::ranges::equal(a.deformations()[i].node_to_world, b.deformations()[j].node_to_world, same_transform);
}
bool same_field(const fields::Field& a, const fields::Field& b) {
  return a.table == b.table && a.density_net == b.density_net && a.color_net == b.color_net &&
         a.occupancy.words() == b.occupancy.words();
}
/// The field without its finer level, of two.
fields::Field coarse(fields::Field field) {
  const std::size_t first = std::size_t{fields::grid_levels(field.config)[1].offset} * fields::FieldConfig::kFeatures;
  std::fill(field.table.begin() + static_cast<std::ptrdiff_t>(first), field.table.end(), 0.0F);
  return field;
}

/// What a clip of which parts may be missing has, against the whole one.
class Parts {
public:
  Parts(const Clip& whole, const Clip& given) : whole_(whole), given_(given) {
    const std::size_t frames = given.times.size();
    note(frames == whole.times.size());
    EXPECT_LE(frames, whole.times.size());
    EXPECT_TRUE(std::equal(given.times.begin(), given.times.end(), whole.times.begin()));
    EXPECT_TRUE(std::equal(given.capture_frames.begin(), given.capture_frames.end(), whole.capture_frames.begin()));
    EXPECT_EQ(given.intrinsics, whole.intrinsics);
    note(given.metadata == whole.metadata);
    note(given.layers.size() == whole.layers.size());
    for (std::size_t f = 0; f < given.camera_to_world.size(); ++f) check_camera(f);
    for (const Layer& layer : given.layers) check_layer(layer);
  }
  /// Nothing is missing.
  bool all() const { return all_; }

private:
  void note(bool is_there) { all_ = all_ && is_there; }

  void check_camera(std::size_t frame) {
    const auto is = [&](const SE3& pose) { return pose.matrix() == given_.camera_to_world[frame].matrix(); };
    note(is(whole_.camera_to_world[frame]));
    EXPECT_TRUE(std::ranges::any_of(whole_.camera_to_world, is)) << "a camera that never was";
  }

  void check_layer(const Layer& layer) {
    const auto is_named = [&](const Layer& other) { return other.name == layer.name; };
    const auto original = std::ranges::find_if(whole_.layers, is_named);
    ASSERT_NE(original, whole_.layers.end()) << layer.name;
    EXPECT_EQ(layer.label, original->label);
    EXPECT_EQ(layer.presence, motion::Presence::of_frames(original->presence.in_frames(given_.times.size())));
    const bool is_whole = same_field(layer.field, original->field);
    note(is_whole);
    EXPECT_TRUE(is_whole || same_field(layer.field, coarse(original->field))) << layer.name;
    ASSERT_EQ(layer.motion.kind(), original->motion.kind());
    note(layer.confidence.has_value() == original->confidence.has_value());
    if (layer.confidence) {
      EXPECT_EQ(layer.confidence->levels(), original->confidence->levels());
    }
    note(layer.joints.has_value() == original->joints.has_value());
    if (layer.joints) {
      EXPECT_TRUE(std::ranges::equal(layer.joints->positions,
                                     std::span(original->joints->positions).first(given_.times.size())));
    }
    const bool has_births = layer.births.are_at_the_start() == original->births.are_at_the_start();
    note(has_births);
    if (has_births) {
      EXPECT_EQ(layer.births, original->births.in_first_frames(static_cast<std::uint32_t>(given_.times.size())));
    }
    if (layer.motion.kind() == motion::MotionKind::kStill) return;
    for (std::size_t f = 0; f < given_.times.size(); ++f) check_motion(layer.motion, original->motion, f);
  }

  void check_motion(const motion::Motion& given, const motion::Motion& whole, std::size_t frame) {
    const bool right = same_place(given, frame, whole, frame) && given.health(frame) == whole.health(frame);
    note(right);
    if (right) return;
    EXPECT_EQ(given.health(frame), motion::Health::kLost);
    bool was = false;
    for (std::size_t f = 0; f < kFrames; ++f) was = was || same_place(given, frame, whole, f);
    EXPECT_TRUE(was) << "a pose that never was";
  }

  const Clip& whole_;
  const Clip& given_;
  bool all_ = true;
};

TEST(DamagedClip, IsGivenWholeWithoutAWordIfNothingIsMissing) {
  const Clip clip = small_clip();
  const Outcome outcome = read_parts(file_of(clip));
  ASSERT_TRUE(outcome.clip);
  testing::expect_equal(*outcome.clip, as_stored(clip));
  EXPECT_TRUE(outcome.missing.empty());
}

TEST(DamagedClip, OfEveryPrefixGivesWhatIsWholeAndSaysWhatIsMissing) {
  const Bytes bytes = file_of(small_clip());
  const Clip whole = read_clip(std::make_unique<container::MemorySource>(bytes, "memory.mkv"));
  std::size_t readable = 0;
  std::size_t with_all_frames = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    SCOPED_TRACE(size);
    const Outcome outcome = read_parts({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)});
    if (!outcome.clip) {
      EXPECT_EQ(readable, 0U) << "a longer prefix gives less than a shorter one";
      continue;
    }
    ++readable;
    Parts(whole, *outcome.clip);
    EXPECT_FALSE(outcome.missing.empty());
    with_all_frames += outcome.clip->times.size() == kFrames ? 1U : 0U;
  }
  EXPECT_GT(readable, with_all_frames);
  EXPECT_GT(with_all_frames, 0U);
}

TEST(DamagedClip, OfEveryPrefixIsRefusedWhereEverythingMustBeThere) {
  const Bytes bytes = file_of(small_clip());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    SCOPED_TRACE(size);
    Bytes prefix(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_THROW(read_clip(std::make_unique<container::MemorySource>(std::move(prefix), "memory.mkv")), Error);
  }
}

class FlippedBits : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(FlippedBits, NeverMakeAClipSilentlyAnother) {
  const Bytes bytes = file_of(small_clip());
  const Clip whole = read_clip(std::make_unique<container::MemorySource>(bytes, "memory.mkv"));
  Random random(GetParam());
  int refused = 0, partial = 0, exact = 0;
  for (int i = 0; i < 2500; ++i) {
    Bytes damaged = bytes;
    const std::size_t at = random.below(static_cast<std::uint32_t>(bytes.size()));
    damaged[at] ^= static_cast<std::byte>(1U << random.below(8));
    SCOPED_TRACE(at);
    const Outcome outcome = read_parts(damaged);
    if (!outcome.clip) {
      ++refused;
      continue;
    }
    const bool all = Parts(whole, *outcome.clip).all();
    EXPECT_TRUE(all || !outcome.missing.empty()) << "something is missing and nothing says so";
    ++(all ? exact : partial);
  }
  EXPECT_GT(refused, 0);
  EXPECT_GT(partial, refused);
  EXPECT_GT(exact, 0);
}

// 10 000 in all.
INSTANTIATE_TEST_SUITE_P(DamagedClip, FlippedBits, ::testing::Values(41, 42, 43, 44));

TEST(DamagedClip, NamesTheLayerAndTheTimesThatAreMissing) {
  const Clip clip = small_clip();
  Bytes bytes = file_of(clip);
  container::Reader reader(std::make_unique<container::MemorySource>(bytes, "memory.mkv"));
  container::Payload payload;
  std::vector<std::uint64_t> motion_of_object;
  std::uint64_t field_of_person = 0;
  std::uint64_t finer_level_of_object = 0;
  while (reader.next(payload)) {
    for (const container::StoredTrack& track : reader.tracks()) {
      if (track.track.id != payload.track) continue;
      if (track.track.name == "motion object") motion_of_object.push_back(payload.offset + payload.stored_bytes - 1);
      const std::uint64_t middle = payload.offset + payload.stored_bytes / 2;
      if (track.track.name == "field person" && payload.key) field_of_person = middle;
      if (track.track.name == "field object" && !payload.key) finer_level_of_object = middle;
    }
  }
  bytes[motion_of_object.at(2)] ^= std::byte{1};
  bytes[motion_of_object.at(3)] ^= std::byte{1};
  bytes[field_of_person] ^= std::byte{1};
  bytes[finer_level_of_object] ^= std::byte{1};
  const Outcome outcome = read_parts(bytes);
  ASSERT_TRUE(outcome.clip);
  EXPECT_EQ(outcome.clip->layers.size(), 2U);
  const std::string sentence = missing_sentence("a.mkv", outcome.missing);
  EXPECT_NE(sentence.find("the motion of layer object in frames 2 to 3 ("), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("the field of layer person and so the whole layer"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("the finer levels of the field of layer object"), std::string::npos) << sentence;
}

TEST(MissingParts, ListsThreeRunsOfFramesAndCountsTheRest) {
  std::vector<bool> there(20, true);
  std::vector<double> times(20);
  for (std::size_t f = 0; f < times.size(); ++f) times[f] = 0.1 * static_cast<double>(f);
  for (const std::size_t f : {1, 2, 5, 8, 9, 11, 13, 14}) there[f] = false;
  EXPECT_EQ(missing_frames(there, times), "frames 1 to 2 (0.10 to 0.20 s), frame 5 (0.50 s), frames 8 to 9 (0.80 to "
                                          "0.90 s) and 3 further frames");
}

} // namespace
} // namespace kinora::clip
