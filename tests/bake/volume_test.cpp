// Sparse volumes of clips whose shapes are known.
#include <gtest/gtest.h>

#include "bake/analytic_field.h"
#include "bake/volume.h"
#include "core/error.h"
#include "core/parallel.h"
#include "fields/scenes/arrow_ball.h"

namespace kinora::bake {
namespace {

using testing::kRadius;

constexpr double kVoxel = 0.03;

clip::Clip clip_of(const motion::Motion& motion, int frames) {
  clip::Clip clip = testing::sample_clip(frames);
  clip.layers = {{"ball", 1, testing::ball_field(), motion}};
  return clip;
}

host::Volume volume_of(const clip::Clip& clip, int frame) {
  std::vector<std::size_t> layers(clip.layers.size());
  for (std::size_t i = 0; i < layers.size(); ++i) layers[i] = i;
  return VolumeBaker(clip, layers, {kVoxel, 0.01}).at(frame, Progress());
}

Eigen::Vector3d place_of(const host::Volume& volume, std::size_t i) {
  const auto& v = volume.voxels[i];
  return (volume.voxel_to_world * Eigen::Vector4d(v[0], v[1], v[2], 1)).head<3>();
}

Eigen::Vector3d middle_of(const host::Volume& volume) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < volume.voxels.size(); ++i) sum += place_of(volume, i);
  return sum / static_cast<double>(volume.voxels.size());
}

TEST(Volume, OfAStillBallFillsIt) {
  const host::Volume volume = volume_of(clip_of(motion::Motion::still(), 1), 0);
  const double ball = 4.0 / 3 * M_PI * std::pow(kRadius, 3);
  const double half_opaque = std::log(2.0) * 48; // per metre, at the surface
  const auto full =
      std::count_if(volume.density.begin(), volume.density.end(), [&](float density) { return density > half_opaque; });
  EXPECT_NEAR(static_cast<double>(full) * std::pow(kVoxel, 3), ball, 0.15 * ball);
  for (std::size_t i = 0; i < volume.voxels.size(); ++i) {
    ASSERT_LT(place_of(volume, i).norm(), kRadius + 3 * kVoxel);
    if (place_of(volume, i).norm() < kRadius - kVoxel) {
      ASSERT_GT(volume.density[i], 100); // per metre
    }
  }
  EXPECT_DOUBLE_EQ(volume.time, 0.5);
}

TEST(Volume, ColorsAreLinearLight) {
  const host::Volume volume = volume_of(clip_of(motion::Motion::still(), 1), 0);
  for (std::size_t i = 0; i < volume.voxels.size(); ++i) {
    if (place_of(volume, i).x() > -0.1 || volume.density[i] < 100) continue;
    ASSERT_NEAR(volume.color[i][0], 0.604, 0.01); // sRGB 0.8
    ASSERT_NEAR(volume.color[i][1], 0.033, 0.01); // sRGB 0.2
  }
}

TEST(Volume, OfARigidLayerFollowsIt) {
  const clip::Clip clip = clip_of(testing::rigid_motion(4), 4);
  for (const int frame : {0, 3}) {
    const Eigen::Vector3d expected = clip.layers[0].motion.canonical_to_world(frame).translation();
    EXPECT_LT((middle_of(volume_of(clip, frame)) - expected).norm(), 0.005);
  }
}

TEST(Volume, ColorsTurnWithTheLayer) {
  const fields::testing::ArrowBall arrows;
  std::vector<motion::Motion::Pose> poses(3);
  for (int i = 0; i < 3; ++i) {
    poses[static_cast<std::size_t>(i)].canonical_to_world =
        arrows.pose(Eigen::AngleAxisd(1.0 * i, Eigen::Vector3d::UnitZ()).toRotationMatrix());
  }
  clip::Clip clip = testing::sample_clip(3);
  clip.layers = {{"ball", 1, arrows.field(), motion::Motion::rigid(poses)}};
  for (int i = 0; i < 3; ++i) {
    const host::Volume volume = volume_of(clip, i);
    const Eigen::Array3d expected = arrows.expected(poses[static_cast<std::size_t>(i)].canonical_to_world.linear());
    std::size_t inside = 0;
    for (std::size_t v = 0; v < volume.voxels.size(); ++v) {
      if ((place_of(volume, v) - arrows.ball.centre).norm() > arrows.ball.radius - 2 * kVoxel) continue;
      ++inside;
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(volume.color[v][static_cast<std::size_t>(c)], std::pow((expected[c] + 0.055) / 1.055, 2.4), 0.02);
      }
    }
    EXPECT_GT(inside, 500U);
  }
}

TEST(Volume, OfADeformingLayerIsWhereItsWarpPutsTheBall) {
  const clip::Clip clip = clip_of(testing::bending_motion(4), 4);
  const motion::Warp warp = clip.layers[0].motion.warp(3);
  const host::Volume volume = volume_of(clip, 3);
  const host::Volume straight = volume_of(clip, 0);
  ASSERT_GT(volume.voxels.size(), 0.8 * static_cast<double>(straight.voxels.size()));
  for (std::size_t i = 0; i < volume.voxels.size(); ++i) {
    const auto canonical = warp.to_canonical(place_of(volume, i));
    ASSERT_TRUE(canonical);
    ASSERT_LT(canonical->norm(), kRadius + 2 * kVoxel);
  }
  EXPECT_NEAR(middle_of(volume).y(), -0.3, 0.01);
}

TEST(Volume, LayersAddUpWhereTheyMeet) {
  clip::Clip once = clip_of(motion::Motion::still(), 1);
  clip::Clip twice = once;
  twice.layers.push_back(twice.layers[0]);
  twice.layers.back().motion = motion::Motion::rigid({{}}); // the same place by another kind of motion
  const host::Volume one = volume_of(once, 0);
  const host::Volume two = volume_of(twice, 0);
  ASSERT_EQ(one.voxels, two.voxels);
  for (std::size_t i = 0; i < one.voxels.size(); ++i) {
    ASSERT_NEAR(two.density[i], 2 * one.density[i], 1e-3F * two.density[i]);
    ASSERT_NEAR(two.color[i][0], one.color[i][0], 1e-3F);
  }
}

TEST(Volume, OfALayerThatHasNotBeenSeenYetIsEmpty) {
  const motion::Motion::Pose lost{SE3::Identity(), motion::Health::kLost};
  const clip::Clip clip = clip_of(motion::Motion::rigid({lost, {}, lost}), 3);
  EXPECT_TRUE(volume_of(clip, 0).voxels.empty());
  EXPECT_FALSE(volume_of(clip, 1).voxels.empty());
  EXPECT_FALSE(volume_of(clip, 2).voxels.empty()) << "it stays where it was last";
}

TEST(Volume, OfALayerThatIsAwayIsEmpty) {
  clip::Clip clip = clip_of(motion::Motion::still(), 3);
  clip.layers[0].presence = motion::Presence::away_during({{0, 1}, {2, 3}});
  EXPECT_TRUE(volume_of(clip, 0).voxels.empty());
  EXPECT_FALSE(volume_of(clip, 1).voxels.empty());
  EXPECT_TRUE(volume_of(clip, 2).voxels.empty());
}

TEST(Volume, IsTheSameForAnyNumberOfThreads) {
  const clip::Clip clip = testing::sample_clip(2);
  set_thread_count(1);
  const host::Volume one = volume_of(clip, 1);
  set_thread_count(3);
  const host::Volume three = volume_of(clip, 1);
  set_thread_count(0);
  EXPECT_EQ(one.voxels, three.voxels);
  EXPECT_EQ(one.density, three.density);
  EXPECT_EQ(one.color, three.color);
}

TEST(Volume, VoxelsThatAreTooSmallForTheSceneAreRefused) {
  clip::Clip clip = clip_of(motion::Motion::rigid({{testing::moved({5000, 0, 0})}}), 1);
  const std::vector<std::size_t> layers = {0};
  VolumeBaker far_away(clip, layers, {0.003, 0.01});
  EXPECT_THROW((void)far_away.at(0, Progress()), Error);
  EXPECT_THROW(VolumeBaker(clip, layers, {0, 0.01}), Error);
}

} // namespace
} // namespace kinora::bake
