// Claims about clips in files, from the outside.
#include "clip/clip_io.h"

#include <cstdlib>
#include <fstream>
#include <numeric>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "clip/clip_description.h"
#include "clip/clip_edit.h"
#include "clip/codec_ids.h"
#include "container/ebml_builder.h"
#include "container/reader.h"
#include "container/writer.h"
#include "core/error.h"
#include "equal_clips.h"
#include "sample_clip.h"

namespace kinora::clip {
namespace {

using container::testing::load;
using container::testing::TemporaryFolder;
using testing::bending_clip;
using testing::expect_equal;

ErrorCode code_of_reading(const std::filesystem::path& path, std::string* sentence = nullptr) {
  try {
    read_clip(path);
  } catch (const Error& error) {
    if (sentence != nullptr) *sentence = error.what();
    return error.code();
  }
  ADD_FAILURE() << path << " was read without an error";
  return ErrorCode::kFailure;
}

void store(const Bytes& bytes, const std::filesystem::path& path) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

TEST(ClipFile, GivesBackTheClipAsStored) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const Clip clip = bending_clip(seed, 1 + seed * 9, seed % 2 == 1);
    write_clip(clip, folder / "a.mkv");
    expect_equal(read_clip(folder / "a.mkv"), as_stored(clip));
  }
}

TEST(ClipFile, IsTheSameFileWhenItsClipIsWrittenAgain) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 10; seed < 14; ++seed) {
    write_clip(bending_clip(seed, 20, true), folder / "a.mkv");
    write_clip(bending_clip(seed, 20, true), folder / "same.mkv");
    write_clip(read_clip(folder / "a.mkv"), folder / "again.mkv");
    EXPECT_EQ(load(folder / "a.mkv"), load(folder / "same.mkv"));
    EXPECT_EQ(load(folder / "a.mkv"), load(folder / "again.mkv"));
  }
}

TEST(ClipFile, KeepsWhenLayersAreAwayWhicheverSpansTheseAre) {
  const TemporaryFolder folder;
  Random random(9);
  constexpr std::size_t kFrames = 12;
  Clip clip = bending_clip(2, kFrames, false);
  for (int round = 0; round < 10; ++round) {
    for (Layer& layer : clip.layers) {
      std::vector<bool> there(kFrames);
      for (std::size_t f = 0; f < kFrames; ++f) there[f] = random.below(2) > 0;
      layer.presence = motion::Presence::of_frames(there);
    }
    std::filesystem::remove(folder / "a.mkv");
    write_clip(clip, folder / "a.mkv");
    const Clip read = read_clip(folder / "a.mkv");
    for (std::size_t l = 0; l < clip.layers.size(); ++l) EXPECT_EQ(read.layers[l].presence, clip.layers[l].presence);
  }
}

TEST(ClipFile, KeepsWhenNodesAreBornAndSpendsNothingWhereAllAreAtTheStart) {
  const TemporaryFolder folder;
  Clip clip = bending_clip(3, 12, false);
  write_clip(clip, folder / "a.mkv");
  EXPECT_TRUE(read_clip(folder / "a.mkv").layers[2].births.are_at_the_start());
  const container::Reader reader(folder / "a.mkv");
  for (const container::StoredTrack& track : reader.tracks()) EXPECT_NE(track.track.codec, kBirthsCodec);
  clip.layers[2].births = testing::random_births(3, clip.layers[2].motion.graph()->nodes().size(), 12);
  write_clip(clip, folder / "b.mkv");
  EXPECT_EQ(read_clip(folder / "b.mkv").layers[2].births, clip.layers[2].births);
}

TEST(ClipFile, AccountsForEveryByte) {
  const TemporaryFolder folder;
  write_clip(bending_clip(20, 30, true), folder / "a.mkv");
  ByteAccount account;
  read_clip(folder / "a.mkv", &account);
  EXPECT_EQ(account.total, std::filesystem::file_size(folder / "a.mkv"));
  std::size_t sum = 0;
  std::vector<std::string> names;
  for (const ByteAccount::Entry& entry : account.entries) {
    EXPECT_GT(entry.bytes, 0U) << entry.name;
    sum += entry.bytes;
    names.push_back(entry.name);
  }
  EXPECT_EQ(sum, account.total);
  EXPECT_EQ(names, (std::vector<std::string>{"camera", "field background", "confidence background", "field object",
                                             "motion object", "field person", "motion person", "joints person",
                                             "timeline", "calibration", "metadata", "container"}));
}

TEST(ClipFile, StoresNoMotionForAStillLayer) {
  const TemporaryFolder folder;
  Clip clip = bending_clip(21, 30, false);
  clip.layers.resize(1, clip.layers[0]);
  write_clip(clip, folder / "a.mkv");
  container::Reader reader(folder / "a.mkv");
  for (const container::StoredTrack& track : reader.tracks()) EXPECT_NE(track.track.codec, "S_KINORA/MOTION");
}

TEST(ClipFile, RefusesADeformingLayerWhoseFramesAreOutOfOrder) {
  const TemporaryFolder folder;
  write_clip(bending_clip(29, 6, false), folder / "a.mkv");
  container::Reader reader(folder / "a.mkv");
  container::FileHead head;
  head.kind = "clip";
  std::uint16_t motion_of_person = 0;
  for (const container::StoredTrack& track : reader.tracks()) {
    head.tracks.push_back(track.track);
    if (track.track.name == "motion person") motion_of_person = track.track.id;
  }
  for (const container::StoredAttachment& stored : reader.attachments()) {
    head.attachments.push_back({stored.name, stored.media_type, stored.description, reader.read_attachment(stored)});
  }
  container::Writer writer(folder / "b.mkv", head);
  container::Payload payload;
  for (bool first = true; reader.next(payload);) {
    const bool person = payload.track == motion_of_person;
    if (!person || !first) writer.write(payload.track, payload.time_ns, payload.key, payload.bytes);
    if (person) first = false;
  }
  writer.finish();
  std::string sentence;
  EXPECT_EQ(code_of_reading(folder / "b.mkv", &sentence), ErrorCode::kCorruptInput);
  EXPECT_NE(sentence.find("frame 1 comes before frame 0"), std::string::npos) << sentence;
}

TEST(ClipFile, SurvivesRemuxingByMkvmerge) {
  if (std::system("command -v mkvmerge > /dev/null 2>&1") != 0) GTEST_SKIP() << "mkvmerge is not installed";
  const TemporaryFolder folder;
  const Clip clip = bending_clip(22, 40, true);
  write_clip(clip, folder / "a.mkv");
  ASSERT_EQ(std::system(
                fmt::format("mkvmerge -q -o {} {}", (folder / "b.mkv").string(), (folder / "a.mkv").string()).c_str()),
            0);
  expect_equal(read_clip(folder / "b.mkv"), as_stored(clip));
}

TEST(ClipFile, IsRefusedWhenItIsCutAnywhere) {
  const TemporaryFolder folder;
  write_clip(bending_clip(23, 3, false), folder / "a.mkv");
  const Bytes whole = load(folder / "a.mkv");
  for (std::size_t size = 0; size < whole.size(); size += 1 + whole.size() / 150) {
    store(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)), folder / "cut.mkv");
    std::string sentence;
    const ErrorCode code = code_of_reading(folder / "cut.mkv", &sentence);
    EXPECT_TRUE(code == ErrorCode::kCorruptInput || size < 4) << size << ": " << sentence;
    EXPECT_NE(sentence.find("cut.mkv"), std::string::npos) << sentence;
  }
}

TEST(ClipFile, NoticesFlippedBitsOfItsPayloads) {
  const TemporaryFolder folder;
  write_clip(bending_clip(24, 5, true), folder / "a.mkv");
  std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;
  {
    container::Reader reader(folder / "a.mkv");
    container::Payload payload;
    while (reader.next(payload)) {
      const std::uint64_t end = payload.offset + payload.stored_bytes;
      ranges.emplace_back(end - payload.bytes.size() - container::kEnvelopeBytes, end);
    }
  }
  const Bytes whole = load(folder / "a.mkv");
  Random random(5);
  for (const auto& [begin, end] : ranges) {
    Bytes damaged = whole;
    damaged[begin + random.below(static_cast<std::uint32_t>(end - begin))] ^=
        static_cast<std::byte>(1U << random.below(8));
    store(damaged, folder / "b.mkv");
    std::string sentence;
    EXPECT_EQ(code_of_reading(folder / "b.mkv", &sentence), ErrorCode::kCorruptInput);
    EXPECT_NE(sentence.find("checksum"), std::string::npos) << sentence;
  }
}

TEST(ClipFile, PlaysWhereALaterVersionAddedTracksAndAttachments) {
  const TemporaryFolder folder;
  write_clip(bending_clip(3, 12, true), folder / "known.mkv");
  const Clip known = read_clip(folder / "known.mkv");
  StoredClip stored = load_stored_clip(folder / "known.mkv");
  stored.tracks.push_back({900, "S_KINORA/SMELL", "of the scene", Bytes(3)});
  stored.payloads[900] = {{900, 0, true, Bytes(40)}, {900, stored.description.times_ns.back(), false, Bytes(5)}};
  stored.attachments.push_back({"later.json", "application/json", "", Bytes(20)});
  write_stored_clip(stored, folder / "later.mkv");
  EXPECT_GT(load(folder / "later.mkv").size(), load(folder / "known.mkv").size());
  expect_equal(read_clip(folder / "later.mkv"), known);
}

TEST(ClipFile, OfALaterLayoutIsRefusedByName) {
  const TemporaryFolder folder;
  write_clip(bending_clip(3, 2, true), folder / "a.mkv");
  Bytes bytes = load(folder / "a.mkv");
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t version = text.find('1', text.find(container::kVersionTag));
  ASSERT_LT(version, bytes.size());
  bytes[version] = std::byte{'2'};
  store(bytes, folder / "a.mkv");
  std::string sentence;
  EXPECT_EQ(code_of_reading(folder / "a.mkv", &sentence), ErrorCode::kNotRecognised);
  EXPECT_NE(sentence.find("its layout has version 2; use a newer Kinora"), std::string::npos) << sentence;
}

TEST(ClipFile, IsToldFromOtherFiles) {
  const TemporaryFolder folder;
  const auto write_kind = [&](const std::string& kind) {
    container::Writer writer(folder / "a.mkv", {kind, {{1, "S_KINORA/TEST", "", {}}}, {}, {}, 0});
    writer.finish();
  };
  write_kind("recording");
  std::string sentence;
  EXPECT_EQ(code_of_reading(folder / "a.mkv", &sentence), ErrorCode::kNotRecognised);
  EXPECT_NE(sentence.find("recording"), std::string::npos) << sentence;
  write_kind("clip"); // and nothing in it
  EXPECT_EQ(code_of_reading(folder / "a.mkv"), ErrorCode::kCorruptInput);
  store(container::testing::bytes_of("nothing of the kind"), folder / "a.mkv");
  EXPECT_EQ(code_of_reading(folder / "a.mkv"), ErrorCode::kNotRecognised);
  EXPECT_EQ(code_of_reading(folder / "missing.mkv"), ErrorCode::kNotRecognised);
}

TEST(ClipFile, SaysThatADiskIsFullOrAFolderMissing) {
  const TemporaryFolder folder;
  const Clip clip = bending_clip(25, 5, false);
  for (const std::filesystem::path& path : {std::filesystem::path("/dev/full"), folder / "missing/a.mkv"}) {
    if (path == "/dev/full" && !std::filesystem::exists(path)) continue;
    try {
      write_clip(clip, path);
      FAIL() << path << " was written without an error";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUnwritableOutput);
      EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos) << error.what();
    }
  }
}

TEST(ClipFile, RefusesClipsThatContradictThemselves) {
  const TemporaryFolder folder;
  const auto expect_refused = [&](const std::function<void(Clip&)>& spoil) {
    Clip clip = bending_clip(26, 6, true);
    spoil(clip);
    try {
      write_clip(clip, folder / "a.mkv");
      FAIL() << "written without an error";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFailure) << error.what();
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "a.mkv")) << "a refused clip left a file behind";
  };
  expect_refused([](Clip& clip) { clip.times[3] = clip.times[2]; });
  expect_refused([](Clip& clip) { clip.times[0] = -1; });
  expect_refused([](Clip& clip) { clip.times[5] = std::nan(""); });
  expect_refused([](Clip& clip) { clip.times.pop_back(); });
  expect_refused([](Clip& clip) { clip.held_out.clear(); });
  expect_refused([](Clip& clip) { clip.camera_to_world.pop_back(); });
  expect_refused([](Clip& clip) { clip.layers[1].name = clip.layers[0].name; });
  expect_refused([](Clip& clip) { clip.layers[1].confidence = clip.layers[0].confidence; });
  expect_refused([](Clip& clip) { clip.layers[1].joints = testing::random_joints(1, clip.times.size()); });
  expect_refused([](Clip& clip) { clip.layers[1].presence = motion::Presence::away_during({{5, 7}}); });
  expect_refused([](Clip& clip) { clip.layers[1].births = motion::NodeBirths({1}); });
  expect_refused([](Clip& clip) { clip.layers[2].births = motion::NodeBirths({1}); });
  expect_refused([](Clip& clip) {
    clip.layers[2].births =
        motion::NodeBirths(std::vector<std::uint32_t>(clip.layers[2].motion.graph()->nodes().size(), 7));
  });
  expect_refused([](Clip& clip) { clip.layers[1].name = "a\xFF"; });
  expect_refused([](Clip& clip) { clip.layers[1].name.clear(); });
  expect_refused([](Clip& clip) { clip.camera_to_world[2].translation().x() = std::nan(""); });
  expect_refused([](Clip& clip) { clip.layers[1].motion = motion::Motion::rigid({{}}); });
  expect_refused([](Clip& clip) {
    const motion::Motion& motion = clip.layers[2].motion;
    clip.layers[2].motion = motion::Motion::deforming(motion.graph(), {motion.deformations()[0]});
  });
  expect_refused([](Clip& clip) {
    const motion::Motion& motion = clip.layers[2].motion;
    std::vector<motion::Motion::Deformation> deformations = motion.deformations();
    deformations[4].node_to_world[7].dual.x() = std::nan("");
    clip.layers[2].motion = motion::Motion::deforming(motion.graph(), std::move(deformations));
  });
  expect_refused([](Clip& clip) { clip.layers[0].field.color_net[0] = std::nanf(""); });
  expect_refused([](Clip& clip) { clip.intrinsics.fx = 0; });
}

TEST(Clip, FindsFramesByTime) {
  Clip clip;
  clip.times = {1.0, 2.0, 4.0};
  EXPECT_DOUBLE_EQ(clip.frame_at(0), 0);
  EXPECT_DOUBLE_EQ(clip.frame_at(1), 0);
  EXPECT_DOUBLE_EQ(clip.frame_at(1.25), 0.25);
  EXPECT_DOUBLE_EQ(clip.frame_at(3), 1.5);
  EXPECT_DOUBLE_EQ(clip.frame_at(4), 2);
  EXPECT_DOUBLE_EQ(clip.frame_at(1e9), 2);
}

TEST(Clip, MovesTheCaptureCameraAlongItsPath) {
  const Clip clip = bending_clip(27, 5, true);
  EXPECT_EQ(clip.capture_camera(3).camera_to_world.matrix(), clip.camera_to_world[3].matrix());
  EXPECT_EQ(clip.capture_camera(99).camera_to_world.matrix(), clip.camera_to_world[4].matrix());
  EXPECT_EQ(clip.capture_camera(-1).camera_to_world.matrix(), clip.camera_to_world[0].matrix());
  const SE3 halfway = interpolate(clip.camera_to_world[1], clip.camera_to_world[2], 0.5);
  EXPECT_TRUE(clip.capture_camera(1.5).camera_to_world.isApprox(halfway, 1e-12));
  const Clip still = bending_clip(28, 5, false);
  EXPECT_EQ(still.capture_camera(2.5).camera_to_world.matrix(), still.camera_to_world[0].matrix());
  EXPECT_EQ(still.capture_camera(2.5).intrinsics, still.intrinsics);
}

} // namespace
} // namespace kinora::clip
