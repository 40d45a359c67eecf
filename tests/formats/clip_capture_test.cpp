// A clip as a capture: what a player draws from the capture's camera.
#include <gtest/gtest.h>

#include "bake/analytic_field.h"
#include "clip/clip_io.h"
#include "formats/damage.h"
#include "player/player.h"

namespace kinora::formats {
namespace {

using namespace kinora::test;

class ClipCapture : public testing::Test {
protected:
  ClipCapture() { clip::write_clip(bake::testing::sample_clip(kFrames), path()); }
  fs::path path() const { return folder_.path() / "clip.mkv"; }

  static constexpr int kFrames = 3;
  TemporaryFolder folder_;
};

TEST_F(ClipCapture, GivesThePicturesDepthAndLabelsOfThePlayer) {
  const CopiedCapture capture = read_capture(path());
  EXPECT_EQ(capture.format, "kinora-clip");
  const player::Player player(clip::read_clip(path()));
  const clip::Clip& clip = player.clip();
  ASSERT_EQ(capture.frames.size(), clip.times.size());
  EXPECT_EQ(capture.info.has_masks, 1);
  EXPECT_EQ(capture.info.camera.fx, clip.intrinsics.fx);
  EXPECT_EQ(capture.info.has_poses, clip.camera_to_world.size() > 1 ? 1 : 0);
  std::size_t measured = 0;
  std::set<int> labels;
  for (std::size_t i = 0; i < capture.frames.size(); ++i) {
    const CopiedFrame& frame = capture.frames[i];
    const auto number = static_cast<double>(i);
    const fields::Picture drawn = player.draw(clip.capture_camera(number), number, player.all_layers());
    const auto* depth = reinterpret_cast<const std::uint16_t*>(frame.depth.data());
    EXPECT_EQ(frame.time, clip.times[i]);
    for (std::size_t p = 0; p < drawn.depth.pixel_count(); ++p) {
      ASSERT_NEAR(depth[p] * frame.depth_unit, drawn.depth.data()[p], 0.5 * frame.depth_unit + 1e-6) << p;
      measured += depth[p] > 0 ? 1 : 0;
      const std::uint8_t* pixel = drawn.color.data() + 4 * p;
      ASSERT_NEAR(std::to_integer<int>(frame.color[3 * p]), pixel[0] * pixel[3] / 255.0, 0.6);
      const std::size_t front = drawn.front.data()[p];
      const int label = front == 0 ? 0 : clip.layers[front - 1].label;
      ASSERT_EQ(std::to_integer<int>(frame.labels[p]), label);
      labels.insert(label);
    }
  }
  EXPECT_GT(measured, 100U) << "something is seen";
  EXPECT_GT(labels.size(), 1U);
}

TEST_F(ClipCapture, LabelsAreThoseOfTheLayersThatAreThere) {
  clip::Clip clip = bake::testing::sample_clip(kFrames);
  clip.layers[0].presence = motion::Presence::away_during({{0, 1}});
  fs::remove(path());
  clip::write_clip(clip, path());
  const CopiedCapture capture = read_capture(path());
  std::set<int> labels;
  for (const std::byte label : capture.frames.at(0).labels) labels.insert(std::to_integer<int>(label));
  EXPECT_EQ(labels, (std::set<int>{0, clip.layers[1].label, clip.layers[2].label}));
}

TEST_F(ClipCapture, AnyFrameCanBeReadAtOnceAndMasksCanBeLeftOut) {
  const CopiedCapture capture = read_capture(path(), "", {{"masks", "false"}});
  EXPECT_EQ(capture.info.has_masks, 0);
  EXPECT_TRUE(capture.frames.at(0).labels.empty());
  const host::PluginTable plugins = host::PluginTable::builtin();
  host::FrameReader reader(plugins.find("kinora-clip"), path(), {});
  for (const int index : {2, 0, 1}) {
    reader.seek(index);
    const auto frame = reader.next();
    ASSERT_TRUE(frame.has_value());
    EXPECT_EQ(pixels_of(frame->frame.depth), capture.frames[static_cast<std::size_t>(index)].depth) << index;
  }
}

TEST_F(ClipCapture, DamagedClipsAreRefusedOrReadAsFarAsTheyGo) {
  expect_bears_truncation(path(), path(), "kinora-clip", kFrames);
}

} // namespace
} // namespace kinora::formats
