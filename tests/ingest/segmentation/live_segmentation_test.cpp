#include <gtest/gtest.h>

#include "moving_scene.h"

namespace kinora::ingest {
namespace {

/// The scene as it comes, with a body from some frame on.
class ComingScene final : public Capture {
public:
  ComingScene(const MovingScene& scene, int enters) : scene_(scene), enters_(enters) {
    info_.frame_count = scene.frames;
    info_.intrinsics = MovingScene::intrinsics();
  }
  const CaptureInfo& info() const override { return info_; }
  const std::vector<SkippedFrame>& skipped() const override { return skipped_; }
  std::optional<Frame> next() override {
    if (next_ >= scene_.frames) return std::nullopt;
    scene_.has_body = next_ >= enters_;
    return scene_.frame(next_++);
  }

private:
  MovingScene scene_;
  int enters_;
  int next_ = 0;
  CaptureInfo info_;
  std::vector<SkippedFrame> skipped_;
};

struct Labelled {
  std::vector<Frame> frames;
  CaptureInfo info;
};

Labelled labelled(const MovingScene& scene, int enters = 0, bool learns_beside = false) {
  ComingScene coming(scene, enters);
  Progress progress;
  LiveLabelling how;
  how.learns_beside = learns_beside;
  const auto capture = live_segmented_capture(coming, how, progress);
  Labelled result;
  while (auto frame = capture->next()) result.frames.push_back(std::move(*frame));
  result.info = capture->info();
  return result;
}

double overlap_with_body(const MovingScene& scene, const Frame& frame) {
  LabelImage truth;
  scene.frame(frame.index, &truth);
  return overlap(frame.labels, truth, 1);
}

MovingScene three_seconds() {
  MovingScene scene;
  scene.frames = 90;
  scene.speed = 0.014;
  return scene;
}

TEST(LiveSegmentation, FollowsABodyThatWalksOnceASecondWasSeen) {
  const MovingScene scene = three_seconds();
  const Labelled seen = labelled(scene);
  ASSERT_FALSE(seen.frames.empty());
  EXPECT_EQ(seen.frames.front().index, 31);
  EXPECT_EQ(seen.frames.size(), 59U);
  for (const Frame& frame : seen.frames) EXPECT_GT(overlap_with_body(scene, frame), 0.85) << frame.index;
  EXPECT_TRUE(seen.info.has_masks);
  EXPECT_EQ(seen.info.labels.at(1).kind, "deforming");
}

TEST(LiveSegmentation, FindsABodyThatComesIntoAnEmptyRoomAtOnce) {
  const MovingScene scene = three_seconds();
  for (const Frame& frame : labelled(scene, 45).frames) {
    if (frame.index >= 45) {
      EXPECT_GT(overlap_with_body(scene, frame), 0.85) << frame.index;
    } else {
      EXPECT_EQ(std::ranges::count(frame.labels.values(), 0), std::ssize(frame.labels.values())) << frame.index;
    }
  }
}

TEST(LiveSegmentation, LearnsBesideAsWell) {
  const MovingScene scene = three_seconds();
  const Labelled seen = labelled(scene, 0, true);
  ASSERT_EQ(seen.frames.size(), 59U);
  for (const Frame& frame : seen.frames) EXPECT_GT(overlap_with_body(scene, frame), 0.85) << frame.index;
}

TEST(LiveSegmentation, LearnsBetterWhenMoreWasSeen) {
  MovingScene scene = three_seconds();
  scene.speed = 0.004; // in the first second it hardly leaves its place
  const Labelled seen = labelled(scene);
  EXPECT_LT(overlap_with_body(scene, seen.frames.front()), overlap_with_body(scene, seen.frames.back()));
}

TEST(LiveSegmentation, OfACaptureThatEndsBeforeEverythingComes) {
  MovingScene scene;
  for (const int frames : {0, 1, 2, 15, 24}) {
    scene.frames = frames;
    const Labelled seen = labelled(scene);
    ASSERT_EQ(seen.frames.size(), static_cast<std::size_t>(frames));
    for (const Frame& frame : seen.frames) EXPECT_TRUE(frame.has_labels());
  }
  EXPECT_GT(overlap_with_body(scene, labelled(scene).frames.back()), 0.85);
}

} // namespace
} // namespace kinora::ingest
