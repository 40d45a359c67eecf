#include <gtest/gtest.h>

#include "core/parallel.h"
#include "ingest/segmentation/mask_completion.h"
#include "moving_scene.h"

namespace kinora::ingest {
namespace {

/// The moving scene with masks in some frames.
class MaskedCapture final : public Capture {
public:
  MaskedCapture(const MovingScene& scene, std::vector<int> masked) : scene_(scene), masked_(std::move(masked)) {
    info_.frame_count = scene.frames;
    info_.has_masks = true;
    info_.labels[1] = {"anna", "deforming", ""};
  }
  const CaptureInfo& info() const override { return info_; }
  const std::vector<SkippedFrame>& skipped() const override { return skipped_; }
  std::optional<Frame> next() override {
    if (next_ >= scene_.frames) return std::nullopt;
    LabelImage truth;
    Frame frame = scene_.frame(next_, &truth);
    if (std::find(masked_.begin(), masked_.end(), next_) != masked_.end()) frame.labels = std::move(truth);
    ++next_;
    return frame;
  }

private:
  MovingScene scene_;
  std::vector<int> masked_;
  int next_ = 0;
  CaptureInfo info_;
  std::vector<SkippedFrame> skipped_;
};

class CountedWarnings final : public Progress {
public:
  void warn(const std::string& /*sentence*/) override { ++count; }
  int count = 0;
};

std::vector<Frame> completed(const MovingScene& scene, const std::vector<int>& masked, Progress& progress) {
  const auto capture =
      segmented_capture([&](const FrameRange& /*range*/) { return std::make_unique<MaskedCapture>(scene, masked); }, {},
                        make_mask_completion(), progress);
  EXPECT_EQ(capture->info().labels.at(1).name, "anna");
  std::vector<Frame> frames;
  while (auto frame = capture->next()) frames.push_back(std::move(*frame));
  return frames;
}

void expect_good(const MovingScene& scene, const std::vector<Frame>& frames) {
  ASSERT_EQ(frames.size(), static_cast<std::size_t>(scene.frames));
  for (int i = 0; i < scene.frames; ++i) {
    LabelImage truth;
    scene.frame(i, &truth);
    ASSERT_TRUE(frames[static_cast<std::size_t>(i)].labels.same_size(truth)) << i;
    EXPECT_GT(overlap(frames[static_cast<std::size_t>(i)].labels, truth, 1), 0.9) << i;
  }
}

TEST(MaskCompletion, CarriesTheFirstMaskThroughACaptureAndSaysSoOnce) {
  const MovingScene scene;
  CountedWarnings progress;
  expect_good(scene, completed(scene, {0}, progress));
  EXPECT_EQ(progress.count, 1);
}

TEST(MaskCompletion, ReachesBackToFramesBeforeTheFirstMaskAndOverLeaps) {
  MovingScene scene;
  scene.frames = 3;
  scene.speed = 0.25; // half the body's width
  Progress progress;
  expect_good(scene, completed(scene, {1}, progress));
}

TEST(MaskCompletion, LeavesMasksAsTheyAreAndIsSilentWhenAllAreThere) {
  MovingScene scene;
  scene.frames = 3;
  CountedWarnings progress;
  const std::vector<Frame> frames = completed(scene, {0, 1, 2}, progress);
  for (int i = 0; i < scene.frames; ++i) {
    LabelImage truth;
    scene.frame(i, &truth);
    EXPECT_TRUE(std::ranges::equal(frames[static_cast<std::size_t>(i)].labels.values(), truth.values()));
  }
  EXPECT_EQ(progress.count, 0);
}

TEST(MaskCompletion, LeavesFramesUnlabelledWhenNoneHasAMask) {
  MovingScene scene;
  scene.frames = 2;
  Progress progress;
  for (const Frame& frame : completed(scene, {}, progress)) EXPECT_TRUE(frame.labels.empty());
}

TEST(MaskCompletion, GivesTheSameBitsForAnyNumberOfThreads) {
  MovingScene scene;
  scene.frames = 4;
  const auto with = [&](int threads) {
    set_thread_count(threads);
    Progress progress;
    const std::vector<Frame> frames = completed(scene, {0}, progress);
    set_thread_count(0);
    return frames.back().labels;
  };
  EXPECT_TRUE(std::ranges::equal(with(1).values(), with(2).values()));
}

} // namespace
} // namespace kinora::ingest
