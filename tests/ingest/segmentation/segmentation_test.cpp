#include <gtest/gtest.h>

#include "core/parallel.h"
#include "ingest/depth/view_reprojection.h"
#include "ingest/frame/reduced_view.h"
#include "ingest/images/plane_finder.h"
#include "ingest/images/surface_components.h"
#include "ingest/segmentation/flat_faces.h"
#include "moving_scene.h"

namespace kinora::ingest {
namespace {

std::unique_ptr<Segmenter> prepared(const MovingScene& scene) {
  auto segmenter = make_motion_segmenter();
  Progress progress;
  segmenter->prepare([&](const FrameRange& range) { return std::make_unique<SceneCapture>(scene, range); }, {},
                     progress);
  return segmenter;
}

void expect_body_labelled(const MovingScene& scene, Segmenter& segmenter) {
  for (int i = 0; i < scene.frames; i += 4) {
    LabelImage truth;
    Frame frame = scene.frame(i, &truth);
    segmenter.label(frame);
    EXPECT_GT(overlap(frame.labels, truth, 1), 0.85) << i;
  }
}

TEST(MotionSegmenter, FindsABodyThatWalksAndThatWasThereFromTheFirstFrame) {
  const MovingScene scene;
  const auto segmenter = prepared(scene);
  expect_body_labelled(scene, *segmenter);
  ASSERT_TRUE(segmenter->labels().contains(1));
  EXPECT_EQ(segmenter->labels().at(1).kind, "deforming");
  EXPECT_FALSE(segmenter->labels().at(1).why.empty());
}

TEST(MotionSegmenter, TakesARoomInWhichNothingMovesForBackground) {
  MovingScene scene;
  scene.has_body = false;
  const auto segmenter = prepared(scene);
  for (int i = 0; i < scene.frames; i += 6) {
    Frame frame = scene.frame(i);
    segmenter->label(frame);
    EXPECT_TRUE(std::all_of(frame.labels.values().begin(), frame.labels.values().end(), [](auto l) { return l == 0; }));
  }
}

TEST(MotionSegmenter, FindsABodyThatWalksBeforeACarriedCamera) {
  MovingScene scene;
  scene.warped = true;
  expect_body_labelled(scene, *prepared(scene));
}

void expect_all_background(const MovingScene& scene) {
  const auto segmenter = prepared(scene);
  for (int i = 0; i < scene.frames; ++i) {
    Frame frame = scene.frame(i);
    segmenter->label(frame);
    EXPECT_EQ(std::count(frame.labels.values().begin(), frame.labels.values().end(), 0),
              std::ssize(frame.labels.values()))
        << i;
  }
}

TEST(MotionSegmenter, TakesAThingThatACarriedCameraLooksPastForBackground) {
  MovingScene scene;
  scene.warped = true;
  scene.speed = 0;
  expect_all_background(scene);
}

TEST(MotionSegmenter, TakesWhatPosesThatErrByMillimetresMoveForBackground) {
  MovingScene scene;
  scene.frames = 48;
  scene.warped = true;
  scene.speed = 0;
  scene.told_wrong = 3;
  expect_all_background(scene);
}

TEST(MotionSegmenter, FindsABodyThatWalksThoughPosesErrByMillimetres) {
  MovingScene scene;
  scene.frames = 48;
  scene.warped = true;
  scene.speed = 0.015;
  scene.told_wrong = 3;
  expect_body_labelled(scene, *prepared(scene));
}

/// Views of a table whose depth is bumpier than it should be, each in its own way; from each to the next the table's
/// texture slides on if `slides`.
class BumpyTable final : public Capture {
public:
  BumpyTable(bool slides, int frames) : slides_(slides) {
    info_.frame_count = frames;
    info_.intrinsics = MovingScene::intrinsics();
  }
  const CaptureInfo& info() const override { return info_; }
  const std::vector<SkippedFrame>& skipped() const override { return skipped_; }
  std::optional<Frame> next() override {
    if (next_ == info_.frame_count) return std::nullopt;
    const Intrinsics& k = info_.intrinsics;
    Frame frame;
    frame.index = next_;
    frame.camera.intrinsics = k;
    frame.color = ColorImage(k.width, k.height, 3);
    frame.depth = DepthImage(k.width, k.height);
    const int slide = slides_ ? 5 * next_ : 0;
    for (int v = 0; v < k.height; ++v) {
      for (int u = 0; u < k.width; ++u) {
        const bool table = std::abs(u - 80) < 45 && std::abs(v - 60) < 35;
        const double bump = 0.05 * std::sin(0.11 * u + 2.5 * next_) * std::cos(0.13 * v + 1.5 * next_);
        frame.depth.at(u, v) = static_cast<float>(table ? 1.2 + bump : 2);
        const bool dark = table && ((u + slide) / 5 + v / 5) % 2 == 0;
        std::fill_n(frame.color.pixel(u, v), 3, static_cast<std::uint8_t>(dark ? 40 : 200));
      }
    }
    ++next_;
    return frame;
  }

private:
  bool slides_;
  int next_ = 0;
  CaptureInfo info_;
  std::vector<SkippedFrame> skipped_;
};

double labelled_pixels_a_frame(bool slides, int frames) {
  Progress progress;
  const auto open = [&](const FrameRange& /*range*/) { return std::make_unique<BumpyTable>(slides, frames); };
  const auto labelled = segmented_capture(open, {}, make_motion_segmenter(), progress);
  std::ptrdiff_t count = 0;
  while (const auto frame = labelled->next())
    count += std::count_if(frame->labels.values().begin(), frame->labels.values().end(), [](auto l) { return l != 0; });
  return static_cast<double>(count) / frames;
}

TEST(MotionSegmenter, DepthThatWaversIsNoMotionIfThePictureKeepsStill) {
  for (const int frames : {2, 30}) { // two tell little, many how it is on the whole
    EXPECT_EQ(labelled_pixels_a_frame(false, frames), 0) << frames;
    EXPECT_GT(labelled_pixels_a_frame(true, frames), 2000) << frames;
  }
}

TEST(MotionSegmenter, GivesTheSameLabelsForAnyNumberOfThreads) {
  const MovingScene scene;
  const auto labels_with = [&](int threads) {
    set_thread_count(threads);
    const auto segmenter = prepared(scene);
    Frame frame = scene.frame(5);
    segmenter->label(frame);
    set_thread_count(0);
    return frame.labels;
  };
  const LabelImage one = labels_with(1);
  const LabelImage three = labels_with(3);
  EXPECT_TRUE(std::equal(one.values().begin(), one.values().end(), three.values().begin()));
}

TEST(PlaneFinder, FindsFloorAndWallWithNormalsTowardsTheCamera) {
  MovingScene scene;
  scene.has_body = false;
  const std::vector<Plane> planes = find_planes(scene.frame(0).depth, MovingScene::intrinsics());
  ASSERT_EQ(planes.size(), 2U);
  for (const Plane& plane : planes) EXPECT_LT(plane.offset, 0);
  const auto has = [&](const Eigen::Vector3d& normal, double distance) {
    return std::any_of(planes.begin(), planes.end(), [&](const Plane& plane) {
      return plane.normal.dot(normal) > 0.999 && std::abs(-plane.offset - distance) < 0.01;
    });
  };
  EXPECT_TRUE(has({0, 0, -1}, 2.5));
  EXPECT_TRUE(has({0, -1, 0}, 0.8));
}

TEST(SeenFrom, TheViewsOwnCameraSeesTheViewItself) {
  const MovingScene scene;
  const ReducedView view = reduced_view(scene.frame(3), 1);
  const ReducedView same = reproject({view.intrinsics, view.camera_to_world}, view);
  EXPECT_TRUE(std::ranges::equal(same.depth.values(), view.depth.values()));
  EXPECT_TRUE(std::ranges::equal(same.color.values(), view.color.values()));
}

TEST(SeenFrom, AnotherCameraSeesTheSurfacesWhereTheyAreAndKnowsWhatItDoesNotSee) {
  MovingScene scene;
  scene.has_body = false;
  const ReducedView view = reduced_view(scene.frame(0), 1);
  SE3 aside = SE3::Identity();
  aside.translation().x() = 0.5;
  const ReducedView seen = reproject({view.intrinsics, aside}, view);
  EXPECT_NEAR(seen.depth.at(60, 20), 2.5, 0.05); // the wall
  EXPECT_EQ(seen.depth.at(155, 20), kUnseen);    // right of what the view shows
  EXPECT_NE(seen.depth.at(100, 110), kUnseen);   // the floor
}

TEST(SurfaceComponents, AreCutAtJumpsAndBridgeSmallHoles) {
  DepthImage depth(40, 20, 1, 1.0F);
  for (int v = 0; v < 20; ++v) {
    for (int u = 20; u < 40; ++u) depth.at(u, v) = 1.2F;
    depth.at(10, v) = depth.at(11, v) = 0;
  }
  const Mask all(40, 20, 1, 1);
  const SurfaceComponents parts = surface_components(depth, all, {40, 20, 50, 50, 20, 10});
  ASSERT_EQ(parts.list.size(), 2U);
  EXPECT_EQ(parts.list[0].pixels, 18U * 20U);
  EXPECT_EQ(parts.map.at(0, 0), parts.map.at(15, 5));
  EXPECT_NE(parts.map.at(0, 0), parts.map.at(25, 5));
  EXPECT_EQ(parts.largest(), 1);
}

TEST(FlatFaces, AreFoundOnABoardAndNotOnARoundBody) {
  const Intrinsics k{160, 120, 140, 140, 79.5, 59.5};
  DepthImage depth(160, 120);
  Mask foreground(160, 120);
  Random random(3);
  for (int v = 20; v < 100; ++v) {
    for (int u = 10; u < 60; ++u) { // a ball of 25 cm
      const Eigen::Vector2d off((u - 35) / 140.0, (v - 60) / 140.0);
      const double square = 0.18 * 0.18 - off.squaredNorm();
      if (square < 0.005) continue;
      depth.at(u, v) = static_cast<float>(1.2 - std::sqrt(square) + 0.3 * kSensorNoise.sigma(1) * random.normal());
    }
    for (int u = 100; u < 140; ++u)
      if (v >= 40 && v < 80)
        depth.at(u, v) = static_cast<float>(1 + 0.002 * (u - 120) + kSensorNoise.sigma(1) * random.normal());
  }
  for (std::size_t i = 0; i < depth.pixel_count(); ++i) foreground.data()[i] = depth.data()[i] > 0 ? 1 : 0;
  const Mask faces = flat_faces(depth, foreground, k);
  int on_board = 0;
  int on_ball = 0;
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 80; ++u) on_ball += faces.at(u, v);
    for (int u = 80; u < 160; ++u) on_board += faces.at(u, v);
  }
  EXPECT_GT(on_board, 0.85 * 40 * 40);
  EXPECT_EQ(on_ball, 0);
}

} // namespace
} // namespace kinora::ingest
