#include "tracking/deforming/deforming_tracker.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/parallel.h"
#include "motion/point_track.h"
#include "tracking/scenes/bending_plate.h"

namespace kinora::tracking {
namespace {

using testing::Plate;
using testing::pose_at;
using testing::render_plate;
using testing::SceneOptions;

SceneOptions noisy() {
  SceneOptions options;
  options.noise = 1;
  options.width = 160;
  options.height = 120;
  options.focal = 160;
  return options;
}

motion::Motion follow(const std::vector<Plate>& plates, const SceneOptions& options = noisy(),
                      const SE3& camera_to_world = SE3::Identity()) {
  DeformingTracker tracker(2);
  for (std::size_t i = 0; i < plates.size(); ++i) {
    const auto result = tracker.track(render_plate(plates[i], camera_to_world, static_cast<int>(i), options));
    EXPECT_EQ(result.health, motion::Health::kTracked) << "frame " << i;
  }
  return tracker.motion();
}

// Mean error at the last frame of points that are followed from the first, in metres.
double mean_error(const std::vector<Plate>& plates, const motion::Motion& motion) {
  double sum = 0;
  int count = 0;
  for (double x = -0.22; x < 0.23; x += 0.04) {
    for (double y = -0.16; y < 0.17; y += 0.04) {
      const auto track = motion::track_point(motion, plates.size(), 0, plates.front().position(x, y));
      sum += (track.back() - plates.back().position(x, y)).norm();
      ++count;
    }
  }
  return sum / count;
}

double unmoved_error(const std::vector<Plate>& plates) {
  double sum = 0;
  int count = 0;
  for (double x = -0.22; x < 0.23; x += 0.04) {
    for (double y = -0.16; y < 0.17; y += 0.04) {
      sum += (plates.front().position(x, y) - plates.back().position(x, y)).norm();
      ++count;
    }
  }
  return sum / count;
}

template <class Change> std::vector<Plate> plates_of(int count, const Change& change) {
  std::vector<Plate> plates(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    Plate& plate = plates[static_cast<std::size_t>(i)];
    plate.to_world = SE3(Eigen::Translation3d(0, 0, 1));
    change(plate, static_cast<double>(i) / (count - 1));
  }
  return plates;
}

std::vector<Plate> bending(int count) {
  return plates_of(count, [](Plate& plate, double t) { plate.curvature = 3 * t; });
}

TEST(DeformingTracker, FollowsAPlateThatBends) {
  const auto plates = bending(12);
  EXPECT_GT(unmoved_error(plates), 0.025);
  EXPECT_LT(mean_error(plates, follow(plates)), 0.004);
}

TEST(DeformingTracker, FollowsAPlateThatTurnsAndBendsTheOtherWay) {
  const auto plates = plates_of(12, [](Plate& plate, double t) {
    plate.curvature = 1.5 - 3 * t;
    plate.to_world = pose_at({0.1 * t, 0, 1 + 0.1 * t}, 0, 30 * t, 10 * t);
  });
  EXPECT_GT(unmoved_error(plates), 0.1);
  EXPECT_LT(mean_error(plates, follow(plates)), 0.008);
}

TEST(DeformingTracker, FollowsAPlateThatStretches) {
  const auto plates = plates_of(10, [](Plate& plate, double t) { plate.stretch = 0.1 * t; });
  EXPECT_GT(unmoved_error(plates), 0.01);
  EXPECT_LT(mean_error(plates, follow(plates)), 0.004);
}

TEST(DeformingTracker, HiddenPartsFollowWhatIsSeen) {
  const auto plates = plates_of(10, [](Plate& plate, double t) {
    plate.to_world = pose_at({0, 0.08 * t, 1 - 0.1 * t}, 0, 0, 8 * t);
  });
  SceneOptions options = noisy();
  DeformingTracker tracker(2);
  for (std::size_t i = 0; i < plates.size(); ++i) {
    options.occluded_columns = i == 0 ? 0 : 73;
    EXPECT_EQ(tracker.track(render_plate(plates[i], SE3::Identity(), static_cast<int>(i), options)).health,
              motion::Health::kTracked);
  }
  EXPECT_LT(mean_error(plates, tracker.motion()), 0.015);
}

TEST(DeformingTracker, ARepeatedFrameMovesNothing) {
  Plate plate;
  plate.curvature = 1;
  plate.to_world = SE3(Eigen::Translation3d(0, 0, 1));
  const ingest::Frame frame = render_plate(plate, SE3::Identity(), 0, noisy());
  DeformingTracker tracker(2);
  for (int i = 0; i < 6; ++i) tracker.track(frame);
  EXPECT_LT(mean_error({6, plate}, tracker.motion()), 0.001);
}

TEST(DeformingTracker, IsAsExactAKilometreAwayFromTheWorldsOrigin) {
  const auto plates = bending(6);
  const SE3 far_away(Eigen::Translation3d(1000, -300, 700));
  auto moved_plates = plates;
  for (Plate& plate : moved_plates) plate.to_world = far_away * plate.to_world;
  const motion::Motion here = follow(plates);
  const motion::Motion there = follow(moved_plates, noisy(), far_away);
  EXPECT_NEAR(mean_error(plates, here), mean_error(moved_plates, there), 2e-4);
}

void expect_same(const motion::Motion& a, const motion::Motion& b) {
  ASSERT_EQ(a.graph()->nodes(), b.graph()->nodes());
  ASSERT_EQ(a.deformations().size(), b.deformations().size());
  for (std::size_t f = 0; f < a.deformations().size(); ++f) {
    for (std::size_t i = 0; i < a.graph()->nodes().size(); ++i) {
      const DualQuaternion& of_a = a.deformations()[f].node_to_world[i];
      const DualQuaternion& of_b = b.deformations()[f].node_to_world[i];
      EXPECT_EQ(of_a.real.coeffs(), of_b.real.coeffs());
      EXPECT_EQ(of_a.dual.coeffs(), of_b.dual.coeffs());
    }
  }
}

TEST(DeformingTracker, IsTheSameForOneThreadAndMany) {
  const auto plates = bending(5);
  std::vector<motion::Motion> motions;
  for (const int threads : {1, 4}) {
    set_thread_count(threads);
    motions.push_back(follow(plates));
  }
  set_thread_count(0);
  expect_same(motions[0], motions[1]);
}

/// Two plates of one label, seen at once.
ingest::Frame both_of(const Plate& left, const Plate& right, int index) {
  ingest::Frame frame = render_plate(left, SE3::Identity(), index, noisy());
  const ingest::Frame other = render_plate(right, SE3::Identity(), index, noisy());
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      if (other.label_at(u, v) != 2) continue;
      frame.labels.at(u, v) = 2;
      frame.depth.at(u, v) = other.depth.at(u, v);
      frame.clean_depth.at(u, v) = other.clean_depth.at(u, v);
      for (int c = 0; c < 3; ++c) frame.color.at(u, v, c) = other.color.at(u, v, c);
    }
  }
  return frame;
}

// Side by side they are one surface; then the right one comes nearer by a quarter of a metre.
TEST(DeformingTracker, PartsSurfacesThatTouchedAtFirst) {
  DeformingTracker tracker(2);
  constexpr int kFrames = 20;
  Plate left, right;
  left.to_world = SE3(Eigen::Translation3d(-0.2, 0, 1));
  right.to_world = SE3(Eigen::Translation3d(0.2, 0, 1));
  const Plate first = right;
  for (int i = 0; i < kFrames; ++i) {
    right.to_world = SE3(Eigen::Translation3d(0.2, 0, 1 - 0.25 * i / (kFrames - 1)));
    ASSERT_EQ(tracker.track(both_of(left, right, i)).health, motion::Health::kTracked) << i;
  }
  const motion::Motion motion = tracker.motion();
  double nearest = 10, farthest = 0; // node of the canonical pose
  for (const Eigen::Vector3d& node : motion.graph()->nodes()) {
    nearest = std::min(nearest, node.z());
    farthest = std::max(farthest, node.z());
  }
  EXPECT_GT(farthest - nearest, 0.12);
  double worst = 0; // at the seam
  for (double y = -0.14; y < 0.15; y += 0.04) {
    const auto track = motion::track_point(motion, kFrames, 0, first.position(-0.15, y));
    worst = std::max(worst, (track.back() - right.position(-0.15, y)).norm());
  }
  EXPECT_LT(worst, 0.02);
}

TEST(DeformingTracker, IsHeldWhileUnseenAndFoundAgain) {
  const auto plates = bending(8);
  DeformingTracker tracker(2);
  for (int i = 0; i < 4; ++i) {
    tracker.track(render_plate(plates[static_cast<std::size_t>(i)], SE3::Identity(), i, noisy()));
  }
  SceneOptions covered = noisy();
  covered.occluded_columns = covered.width;
  for (int i = 4; i < 7; ++i) {
    EXPECT_EQ(tracker.track(render_plate(plates[3], SE3::Identity(), i, covered)).health, motion::Health::kHeld);
  }
  Plate back = plates[4];
  back.to_world = SE3(Eigen::Translation3d(0.12, -0.05, 1.02));
  EXPECT_EQ(tracker.track(render_plate(back, SE3::Identity(), 7, noisy())).health, motion::Health::kTracked);
  std::vector<Plate> all(8, plates[0]);
  all.back() = back;
  EXPECT_LT(mean_error(all, tracker.motion()), 0.008);
}

TEST(DeformingTracker, FindsALayerThatJumpedAcrossTheView) {
  auto plates = plates_of(2, [](Plate& plate, double t) {
    plate.half_width = 0.15;
    plate.half_height = 0.12;
    plate.to_world = pose_at({-0.15 + 0.3 * t, 0.1 * t, 1 + 0.1 * t}, 0, 0, 5 * t);
    plate.curvature = t;
  });
  DeformingTracker tracker(2);
  tracker.track(render_plate(plates[0], SE3::Identity(), 0, noisy()));
  ASSERT_EQ(tracker.track(render_plate(plates[1], SE3::Identity(), 1, noisy())).health, motion::Health::kTracked);
  const auto track = motion::track_point(tracker.motion(), 2, 0, plates[0].position(0.1, 0.05));
  EXPECT_LT((track[1] - plates[1].position(0.1, 0.05)).norm(), 0.01);
}

TEST(DeformingTracker, FramesBeforeTheFirstAreLostAndStandStill) {
  const auto plates = bending(3);
  SceneOptions covered = noisy();
  covered.occluded_columns = covered.width;
  DeformingTracker tracker(2);
  EXPECT_EQ(tracker.track(render_plate(plates[0], SE3::Identity(), 0, covered)).health, motion::Health::kLost);
  EXPECT_THROW(tracker.motion(), Error);
  tracker.track(render_plate(plates[1], SE3::Identity(), 1, noisy()));
  const motion::Motion motion = tracker.motion();
  ASSERT_EQ(motion.deformations().size(), 2U);
  EXPECT_EQ(motion.health(0), motion::Health::kLost);
  EXPECT_EQ(motion.health(1), motion::Health::kTracked);
  const Eigen::Vector3d point = plates[1].position(0.1, 0.1);
  EXPECT_LT((motion::track_point(motion, 2, 1, point)[0] - point).norm(), 1e-4);
}

TEST(DeformingTracker, TakesAFrameWithoutLabelsAsAWhole) {
  Plate plate;
  plate.half_width = plate.half_height = 2;
  plate.to_world = SE3(Eigen::Translation3d(0, 0, 1));
  ingest::Frame frame = render_plate(plate, SE3::Identity(), 0, noisy());
  frame.labels = {};
  DeformingTracker tracker(1);
  EXPECT_EQ(tracker.track(frame).health, motion::Health::kTracked);
  plate.to_world = SE3(Eigen::Translation3d(0, 0, 0.99));
  ingest::Frame next = render_plate(plate, SE3::Identity(), 1, noisy());
  next.labels = {};
  EXPECT_EQ(tracker.track(next).health, motion::Health::kTracked);
  const auto track = motion::track_point(tracker.motion(), 2, 0, {0, 0, 1});
  EXPECT_NEAR(track[1].z(), 0.99, 0.002);
}

TEST(DeformingTracker, NewSurfaceGetsNodesWithAPast) {
  // A wide plate comes out from behind an occluder.
  SceneOptions options = noisy();
  DeformingTracker tracker(2);
  std::size_t first = 0;
  std::size_t last = 0;
  for (int i = 0; i < 16; ++i) {
    Plate plate;
    plate.to_world = SE3(Eigen::Translation3d(-0.05 + 0.003 * i, 0, 1));
    options.occluded_columns = 87 - 5 * std::min(i, 10);
    last = tracker.track(render_plate(plate, SE3::Identity(), i, options)).nodes;
    if (i == 0) first = last;
  }
  EXPECT_GT(last, first + 5);
  Plate now;
  now.to_world = SE3(Eigen::Translation3d(-0.05 + 0.003 * 15, 0, 1));
  const Eigen::Vector3d before = Eigen::Vector3d(-0.05, 0, 0) - Eigen::Vector3d(-0.005, 0, 0);
  const auto track = motion::track_point(tracker.motion(), 16, 15, now.position(-0.1, 0.05));
  EXPECT_LT((track[0] - (now.position(-0.1, 0.05) + before)).norm(), 0.006);
}

// A plate that bends while it comes out from behind an occluder.
Plate unveiled_plate(int frame) {
  Plate plate;
  plate.curvature = -1.5 + 0.2 * frame;
  plate.to_world = SE3(Eigen::Translation3d(-0.05, 0, 1));
  return plate;
}

constexpr int kUnveiledFrames = 18;

DeformingTracker follow_unveiled_plate() {
  SceneOptions options = noisy();
  DeformingTracker tracker(2);
  for (int i = 0; i < kUnveiledFrames; ++i) {
    options.occluded_columns = 87 - 5 * std::min(i, 12);
    tracker.track(render_plate(unveiled_plate(i), SE3::Identity(), i, options));
  }
  return tracker;
}

// Mean error over all frames of points that come out, followed back from the last frame.
double error_of_past(const motion::Motion& motion) {
  double sum = 0;
  int count = 0;
  for (double x = -0.16; x < 0.01; x += 0.04) {
    for (double y = -0.12; y < 0.13; y += 0.04) {
      const auto track = motion::track_point(motion, kUnveiledFrames, kUnveiledFrames - 1,
                                             unveiled_plate(kUnveiledFrames - 1).position(x, y));
      for (int i = 0; i < kUnveiledFrames; ++i) {
        sum += (track[static_cast<std::size_t>(i)] - unveiled_plate(i).position(x, y)).norm();
        ++count;
      }
    }
  }
  return sum / count;
}

TEST(DeformingTracker, SettlesThePastOfNodesFoundLate) {
  DeformingTracker tracker = follow_unveiled_plate();
  const double guessed = error_of_past(tracker.motion());
  const double settled = error_of_past(std::move(tracker).finish().value().motion);
  EXPECT_LT(settled, 0.75 * guessed); // 12.4 mm of 19.4 mm
}

TEST(DeformingTracker, SettlesThePastAlikeWithAnyNumberOfThreads) {
  std::vector<motion::Motion> motions;
  for (const int threads : {1, 4}) {
    set_thread_count(threads);
    motions.push_back(follow_unveiled_plate().finish().value().motion);
  }
  set_thread_count(0);
  expect_same(motions[0], motions[1]);
}

TEST(DeformingTracker, HasNoPastToSettleWhereAllWasSeenFromTheFirst) {
  const Plate plate;
  DeformingTracker tracker(2);
  for (int i = 0; i < 3; ++i) tracker.track(render_plate(plate, pose_at({0, 0, -1}, 0, 0), i, noisy()));
  const motion::Motion before = tracker.motion();
  expect_same(before, std::move(tracker).finish().value().motion);
}

TEST(DeformingTracker, HasNothingToTellOfALayerThatWasNeverSeen) {
  SceneOptions covered = noisy();
  covered.occluded_columns = covered.width;
  DeformingTracker tracker(2);
  tracker.track(render_plate({}, pose_at({0, 0, -1}, 0, 0), 0, covered));
  EXPECT_FALSE(std::move(tracker).finish());
}

TEST(DeformingTracker, RefusesFramesWhoseImagesDifferInSize) {
  ingest::Frame frame = render_plate({}, pose_at({0, 0, -1}, 0, 0), 0);
  frame.color = ColorImage(8, 8, 3);
  DeformingTracker tracker(2);
  EXPECT_THROW(tracker.track(frame), Error);
}

} // namespace
} // namespace kinora::tracking
