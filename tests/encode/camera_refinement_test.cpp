// A camera's path through the field that was trained with it.
#include "encode/camera_refinement.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "fields/scenes/analytic_scene.h"

namespace kinora::encode {
namespace {

using fields::Scene;

constexpr std::size_t kFrames = 16;

SE3 true_pose(std::size_t f) { return Scene().frame(0, 0.05 * (static_cast<double>(f) - 7.5)).camera.camera_to_world; }

/// Another way in each frame: what all frames share would be the world's own place.
SE3 error_in(std::size_t f, double metres) {
  const double angle = 2.4 * static_cast<double>(f);
  const Eigen::Vector3d aside(metres * std::cos(angle), metres * std::sin(angle), 0.5 * metres * std::cos(3 * angle));
  const double turn = 2 * metres * std::sin(2 * angle);
  return SE3(Eigen::Translation3d(aside) * Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()));
}

/// A ball before a wall, all of it background; every camera beside its place by so many metres.
struct Followed {
  FramePass pass{{}, fields::PixelStore(1'000'000, kFrames), {}, {}, 0};
  TrainingPlan plan;

  explicit Followed(double metres, std::size_t not_stored = kFrames) {
    Scene scene;
    scene.waves = 40;
    for (std::size_t f = 0; f < kFrames; ++f) {
      ingest::Frame frame = scene.frame(static_cast<int>(f), 0.05 * (static_cast<double>(f) - 7.5));
      frame.labels = {};
      frame.camera.camera_to_world = error_in(f, metres) * frame.camera.camera_to_world;
      pass.clip.times.push_back(static_cast<double>(f) / 30);
      pass.clip.camera_to_world.push_back(frame.camera.camera_to_world);
      if (f != not_stored) pass.pixels.add(frame, static_cast<int>(f));
    }
    pass.labels[0].plan = {0, "background", motion::MotionKind::kStill, false, "still"};
    plan.layers.push_back({&pass.labels[0], "background", 1'500'000, 0});
  }

  std::optional<CameraRefinement> refined(int passes = 1) {
    EncodeOptions options = EncodeOptions::of(Preset::kFast);
    options.settings.fields.trainer.rays_per_step = 1024;
    options.settings.fields.poses.passes = passes;
    StageTimes times;
    Progress progress;
    return refine_camera(pass, plan, options, times, progress);
  }

  /// Root mean square distance of where the ball's middle is, seen from each camera, to the mean of all.
  double error() const {
    std::vector<Eigen::Vector3d> places;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t f = 0; f < kFrames; ++f) {
      places.push_back(pass.clip.camera_to_world[f] * true_pose(f).inverse() * Scene().centre);
      mean += places.back() / kFrames;
    }
    double sum = 0;
    for (const Eigen::Vector3d& place : places) sum += (place - mean).squaredNorm() / kFrames;
    return std::sqrt(sum);
  }
};

TEST(RefineCamera, PosesThatErrComeNearer) {
  Followed followed(0.008);
  const double before = followed.error();
  const auto refinement = followed.refined();
  ASSERT_TRUE(refinement);
  EXPECT_GT(refinement->frames, kFrames / 2);
  EXPECT_LE(refinement->color_after, refinement->color_before);
  EXPECT_LT(followed.error(), 0.6 * before);
  EXPECT_GT(refinement->metres, 0.002);
  for (const fields::StoredFrame& frame : followed.pass.pixels.frames()) {
    EXPECT_TRUE(frame.camera.camera_to_world.isApprox(
        followed.pass.clip.camera_to_world[static_cast<std::size_t>(frame.frame)], 0))
        << "pixels are seen from where the clip says";
  }
}

TEST(RefineCamera, ASecondPassComesNearerStill) {
  Followed once(0.012);
  Followed twice(0.012);
  once.refined(1);
  twice.refined(2);
  EXPECT_LT(twice.error(), 0.9 * once.error());
}

TEST(RefineCamera, ExactPosesStayWhereTheyAre) {
  Followed followed(0);
  ASSERT_TRUE(followed.refined());
  EXPECT_LT(followed.error(), 0.001) << "metres: an eighth of a pixel's footprint is 3 mm";
}

TEST(RefineCamera, CorrectionsLeadFromThePathThatWasTrackedToTheClips) {
  Followed followed(0.008);
  const std::vector<SE3> before = followed.pass.clip.camera_to_world;
  const auto refinement = followed.refined();
  ASSERT_TRUE(refinement);
  ASSERT_EQ(refinement->corrections.size(), kFrames);
  for (std::size_t f = 0; f < kFrames; ++f) {
    EXPECT_TRUE((refinement->corrections[f] * before[f]).isApprox(followed.pass.clip.camera_to_world[f], 1e-9)) << f;
  }
}

TEST(RefineCamera, AFrameThatIsNotStoredMovesAsThoseBesideIt) {
  Followed followed(0.008, 7);
  const std::vector<SE3> before = followed.pass.clip.camera_to_world;
  followed.refined();
  const auto move = [&](std::size_t f) -> Twist {
    return log_se3(followed.pass.clip.camera_to_world[f] * before[f].inverse());
  };
  EXPECT_LT((move(7) - 0.5 * (move(6) + move(8))).norm(), 1e-6);
  EXPECT_GT(move(7).norm(), 1e-4);
}

TEST(RefineCamera, WhatMovesKeepsItsPlaceBeforeTheCamera) {
  Followed followed(0.008);
  constexpr std::size_t kSheetFrames = kFrames - 4;
  const Eigen::Vector3d node(0, 0, 1.5);
  const auto graph =
      std::make_shared<motion::DeformationGraph>(std::vector{node, Eigen::Vector3d(0.1, 0, 1.5)}, 0.1, 0.2);
  const std::vector<motion::Motion::Deformation> as_it_was(
      kSheetFrames, {{DualQuaternion::from(error_in(1, 0.1)), DualQuaternion::from(SE3::Identity())}});
  TrackedLabel& object = followed.pass.labels[2];
  object.plan.motion = motion::MotionKind::kRigid;
  object.poses.assign(kFrames, {SE3(Eigen::Translation3d(0.1, 0, 1.5)), motion::Health::kTracked});
  TrackedLabel& person = followed.pass.labels[1];
  person.first_frame = static_cast<int>(kFrames - kSheetFrames); // lost before
  person.poses.assign(kFrames - kSheetFrames, {SE3::Identity(), motion::Health::kLost});
  person.layer = tracking::TrackedLayer{motion::Motion::deforming(graph, as_it_was), {}, 0.1, tracking::LayerBody()};
  const std::vector<SE3> before = followed.pass.clip.camera_to_world;
  const motion::Motion tracked = person.motion();
  ASSERT_TRUE(followed.refined());
  const motion::Motion moved = person.motion();
  for (std::size_t f = 0; f < kFrames; ++f) {
    const SE3& camera = followed.pass.clip.camera_to_world[f];
    EXPECT_TRUE((camera.inverse() * object.poses[f].canonical_to_world)
                    .isApprox(before[f].inverse() * SE3(Eigen::Translation3d(0.1, 0, 1.5)), 1e-9))
        << f;
    if (f < person.poses.size()) continue;
    const auto place = [&](const motion::Motion& motion) -> Eigen::Vector3d {
      return motion.deformations()[f].node_to_world.front().to_se3() * node;
    };
    EXPECT_LT((camera.inverse() * place(moved) - before[f].inverse() * place(tracked)).norm(), 1e-9) << f;
  }
}

TEST(RefineCamera, LeavesACameraThatStandsStillAndOneThatIsNotAskedFor) {
  Followed followed(0.008);
  EXPECT_FALSE(followed.refined(0));
  followed.pass.clip.camera_to_world.resize(1);
  EXPECT_FALSE(followed.refined());
  Followed without_background(0.008);
  without_background.plan.layers.clear();
  EXPECT_FALSE(without_background.refined());
}

TEST(RefineCamera, GivesTheSameForAnyNumberOfThreads) {
  const auto path_with = [](int threads) {
    set_thread_count(threads);
    Followed followed(0.008);
    followed.refined();
    set_thread_count(0);
    return followed.pass.clip.camera_to_world;
  };
  const std::vector<SE3> one = path_with(1), two = path_with(2);
  for (std::size_t f = 0; f < kFrames; ++f) EXPECT_TRUE(one[f].isApprox(two[f], 0)) << f;
}

} // namespace
} // namespace kinora::encode
