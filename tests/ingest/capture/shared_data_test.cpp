// Real captures and a synthetic one, where they are there; never part of the repository.
#include <gtest/gtest.h>

#include "evaluate/ground_truth.h"
#include "host/plugin_table.h"
#include "ingest/capture/capture.h"
#include "ingest/segmentation/segmenter.h"
#include "support/source_folder.h"

namespace kinora::ingest {
namespace {

namespace fs = std::filesystem;

struct Expected {
  const char* folder;
  const char* format;
  int frames;
  int width;
  int height;
  bool poses;
  bool masks;
};

const fs::path kData = test::source_folder() / ".." / "shared" / "data";

class SharedData : public testing::TestWithParam<Expected> {};

TEST_P(SharedData, IsRecognisedAndReadWithoutAFlag) {
  const Expected expected = GetParam();
  if (!fs::exists(kData / expected.folder)) GTEST_SKIP() << (kData / expected.folder).string() << " is not there";
  Progress progress;
  const host::PluginTable plugins = host::PluginTable::builtin();
  CaptureOptions options;
  options.frames.end = std::min(expected.frames, 3);
  const auto capture = Capture::open(plugins, kData / expected.folder, options, progress);
  EXPECT_EQ(capture->info().format, expected.format);
  EXPECT_EQ(capture->info().frame_count, expected.frames);
  EXPECT_EQ(capture->info().intrinsics.width, expected.width);
  EXPECT_EQ(capture->info().intrinsics.height, expected.height);
  EXPECT_EQ(capture->info().has_poses, expected.poses);
  EXPECT_EQ(capture->info().has_masks, expected.masks);
  int frames = 0;
  while (const auto frame = capture->next()) {
    ++frames;
    std::size_t measured = 0;
    std::size_t clean = 0;
    for (std::size_t i = 0; i < frame->depth.pixel_count(); ++i) {
      if (frame->depth.data()[i] <= 0) continue;
      EXPECT_GT(frame->depth.data()[i], 0.1);
      ++measured;
      if (frame->clean_depth.data()[i] > 0) ++clean;
    }
    EXPECT_GT(static_cast<double>(clean), 0.75 * static_cast<double>(measured));
  }
  EXPECT_EQ(frames, *options.frames.end);
  EXPECT_TRUE(capture->skipped().empty());
}

INSTANTIATE_TEST_SUITE_P(
    All, SharedData,
    testing::Values(Expected{"carry_box", "tum-rgbd", 90, 640, 480, false, true},
                    Expected{"static_3dmatch50", "3dmatch", 50, 640, 480, true, false},
                    Expected{"squirrel_handling", "numbered-folder", 240, 320, 240, false, false},
                    Expected{"depthkit_person_laptop", "numbered-folder", 48, 512, 424, false, false},
                    Expected{"m3t_pair", "m3t", 2, 960, 540, false, false},
                    Expected{"m3t_pair/_sequence", "m3t", 2, 960, 540, false, false},
                    Expected{"deepdeform_pairs/train/seq258", "numbered-folder", 2, 640, 480, false, true},
                    Expected{"deepdeform_pairs/test/seq017", "numbered-folder", 2, 640, 480, false, false}),
    [](const auto& parameter) {
      std::string name = parameter.param.folder;
      std::replace_if(
          name.begin(), name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
      return name;
    });

struct Still {
  const char* folder;
  int step; ///< between the frames that are looked at
};

class StillSharedData : public testing::TestWithParam<Still> {};

TEST_P(StillSharedData, IsAllBackground) {
  const fs::path folder = kData / GetParam().folder;
  if (!fs::exists(folder)) GTEST_SKIP() << folder.string() << " is not there";
  Progress progress;
  const host::PluginTable plugins = host::PluginTable::builtin();
  const auto open = [&](const FrameRange& range) {
    CaptureOptions options;
    options.frames = range;
    return Capture::open(plugins, folder, options, progress);
  };
  const auto labelled = segmented_capture(open, {0, std::nullopt, GetParam().step}, make_motion_segmenter(), progress);
  while (const auto frame = labelled->next()) {
    const auto values = frame->labels.values();
    EXPECT_EQ(std::count(values.begin(), values.end(), 0), std::ssize(values)) << "frame " << frame->index;
  }
}

// The kitchen's poses err by millimetres, and the stereo camera's depth by centimetres.
INSTANTIATE_TEST_SUITE_P(All, StillSharedData, testing::Values(Still{"static_3dmatch50", 2}, Still{"m3t_pair", 1}),
                         [](const auto& parameter) { return std::string(parameter.param.folder); });

TEST(SharedDataTruth, CarryBoxHasFourCamerasAndAnObject) {
  if (!fs::exists(kData / "carry_box")) GTEST_SKIP() << "carry_box is not there";
  const auto truth = evaluate::GroundTruth::read(kData / "carry_box");
  ASSERT_TRUE(truth);
  ASSERT_EQ(truth->novel_cameras().size(), 4U);
  EXPECT_EQ(truth->object_to_camera().size(), 90U);
  ASSERT_TRUE(truth->object_centroid());
  EXPECT_LT(truth->object_centroid()->norm(), 0.01);
  const evaluate::NovelView view = truth->novel_view(truth->novel_cameras()[0], truth->novel_cameras()[0].frames.at(1));
  EXPECT_TRUE(view.color.same_size(view.depth));
  EXPECT_TRUE(view.color.same_size(view.mask));
}

} // namespace
} // namespace kinora::ingest
