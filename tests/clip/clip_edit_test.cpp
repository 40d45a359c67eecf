// Claims about cutting clips and joining the pieces.
#include "clip/clip_edit.h"

#include <gtest/gtest.h>

#include "clip/clip_io.h"
#include "container/ebml_builder.h"
#include "core/error.h"
#include "equal_clips.h"
#include "sample_clip.h"

namespace kinora::clip {
namespace {

using container::testing::load;
using container::testing::TemporaryFolder;

constexpr std::size_t kFrames = 70; // three segments of deformations

/// What the frames begin to end − 1 of a clip in memory are.
Clip frames_of(Clip clip, std::size_t begin, std::size_t end) {
  const auto slice = [begin, end](auto& values) {
    values.erase(values.begin() + static_cast<std::ptrdiff_t>(end), values.end());
    values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(begin));
  };
  slice(clip.times);
  slice(clip.capture_frames);
  slice(clip.held_out);
  if (clip.camera_to_world.size() > 1) slice(clip.camera_to_world);
  for (Layer& layer : clip.layers) {
    if (layer.joints) slice(layer.joints->positions);
    std::vector<bool> there = layer.presence.in_frames(kFrames);
    slice(there);
    layer.presence = motion::Presence::of_frames(there);
    std::vector<std::uint32_t> births = layer.births.frames();
    for (std::uint32_t& birth : births)
      birth = static_cast<std::uint32_t>(std::clamp<std::size_t>(birth, begin, end) - begin);
    layer.births = motion::NodeBirths(std::move(births));
    if (layer.motion.kind() == motion::MotionKind::kRigid) {
      std::vector<motion::Motion::Pose> poses = layer.motion.poses();
      slice(poses);
      layer.motion = motion::Motion::rigid(std::move(poses));
    } else if (layer.motion.graph()) {
      std::vector<motion::Motion::Deformation> deformations = layer.motion.deformations();
      slice(deformations);
      layer.motion = motion::Motion::deforming(layer.motion.graph(), std::move(deformations));
    }
  }
  return clip;
}

class ClipEdit : public ::testing::Test {
protected:
  ClipEdit() {
    Clip clip = testing::bending_clip(5, kFrames, true);
    clip.layers[0].presence = motion::Presence::away_during({{10, 30}});
    clip.layers[1].presence = motion::Presence::away_during({{0, 12}, {29, 31}, {41, kFrames}});
    clip.layers[2].births = testing::random_births(5, clip.layers[2].motion.graph()->nodes().size(), kFrames);
    write_clip(clip, folder_ / "whole.mkv");
    whole_ = read_clip(folder_ / "whole.mkv");
    stored_ = load_stored_clip(folder_ / "whole.mkv");
  }
  Clip read_back(const StoredClip& clip) {
    write_stored_clip(clip, folder_ / "piece.mkv");
    return read_clip(folder_ / "piece.mkv");
  }

  TemporaryFolder folder_;
  Clip whole_;
  StoredClip stored_;
};

TEST_F(ClipEdit, ACutHasTheOriginalsFramesToTheBit) {
  for (const auto& [begin, end] :
       {std::pair<std::size_t, std::size_t>{0, 70}, {0, 12}, {30, 70}, {7, 9}, {29, 65}, {45, 46}}) {
    SCOPED_TRACE(begin);
    testing::expect_equal(read_back(cut(stored_, begin, end)), frames_of(whole_, begin, end));
  }
}

TEST_F(ClipEdit, CuttingNothingOffGivesTheSameFile) {
  write_stored_clip(cut(stored_, 0, kFrames), folder_ / "piece.mkv");
  EXPECT_EQ(load(folder_ / "piece.mkv"), load(folder_ / "whole.mkv"));
}

TEST_F(ClipEdit, JoinedPiecesAreTheOriginal) {
  for (const std::size_t middle : {1, 29, 30, 41, 69}) {
    SCOPED_TRACE(middle);
    testing::expect_equal(read_back(join(cut(stored_, 0, middle), cut(stored_, middle, kFrames))), whole_);
  }
}

TEST_F(ClipEdit, APieceThatIsNotLaterFollowsAFrameAfterTheFirst) {
  const Clip swapped = read_back(join(cut(stored_, 40, 70), cut(stored_, 0, 40)));
  ASSERT_EQ(swapped.times.size(), kFrames);
  EXPECT_GT(swapped.times[30], swapped.times[29]);
  EXPECT_NEAR(swapped.times[31] - swapped.times[30], whole_.times[1] - whole_.times[0], 2e-9);
  EXPECT_EQ(swapped.capture_frames[30], whole_.capture_frames[0]);
}

TEST_F(ClipEdit, PiecesOfDifferentClipsAreNotJoined) {
  write_clip(testing::bending_clip(6, 3, true), folder_ / "other.mkv");
  try {
    join(stored_, load_stored_clip(folder_ / "other.mkv"));
    FAIL() << "joined";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFailure);
    EXPECT_NE(std::string(error.what()).find("no pieces of one clip"), std::string::npos) << error.what();
  }
}

} // namespace
} // namespace kinora::clip
