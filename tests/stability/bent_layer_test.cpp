// A layer that deforms, learnt and drawn as it is used: stored in a file, on other processors, on any number of
// threads, from cameras that stand in the way.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "clip/clip_io.h"
#include "core/metrics.h"
#include "core/parallel.h"
#include "fields/rendering/renderer.h"
#include "fields/scenes/bending_sheet.h"
#include "fields/training/trainer.h"

namespace kinora::fields {
namespace {

constexpr int kSheet = 1;
constexpr int kHeldOutFrame = 7; // bent most of those that no training saw

Field learn(const Performance& performance, std::size_t rays) {
  TrainerConfig trainer;
  trainer.rays = rays;
  trainer.rays_per_step = 1024;
  Progress progress;
  const FieldConfig config = choose_field_config({performance.store, kSheet, performance.motion});
  return train_field({performance.store, kSheet, performance.motion}, config, trainer, progress);
}

Picture draw(const Field& field, const motion::Motion& motion, const Camera& camera) {
  const DrawableField drawable(field, motion.graph().get());
  const PosedField posed = pose(drawable, motion.warp(kHeldOutFrame));
  return render({&posed, 1}, camera);
}

/// Of the held-out frame, silhouette included.
double psnr_of(const Field& field, const motion::Motion& motion) {
  const ingest::Frame truth = sheet_frame(kHeldOutFrame, curvature_at(kHeldOutFrame));
  return compare_images(draw(field, motion, truth.camera).color, truth.color, truth.labels).psnr_box;
}

std::size_t opaque_pixels(const Picture& picture) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < picture.color.pixel_count(); ++i) count += picture.color.data()[4 * i + 3] > 127 ? 1 : 0;
  return count;
}

TEST(BentLayer, LosesLessThanThreeQuartersOfADecibelWhenItIsStored) {
  const Performance performance;
  const Field field = learn(performance, 300'000);
  clip::Clip clip;
  for (int i = 0; i < 9; ++i) {
    clip.times.push_back(i / 30.0);
    clip.capture_frames.push_back(i);
    clip.held_out.push_back(false);
  }
  clip.intrinsics = sheet_frame(0, 0).camera.intrinsics;
  clip.camera_to_world = {SE3::Identity()};
  clip.layers.push_back({"sheet", kSheet, field, performance.motion});
  const clip::Clip stored = clip::as_stored(clip);
  const double unstored_psnr = psnr_of(field, performance.motion);
  EXPECT_GT(unstored_psnr, 20); // there is something to lose
  // Of 37.9 dB: half a decibel by rounding the field, 0.16 by rounding the motion to half a millimetre.
  EXPECT_GT(psnr_of(stored.layers[0].field, stored.layers[0].motion), unstored_psnr - 0.75);
}

TEST(BentLayer, IsDrawnAlikeOnEveryInstructionSet) {
  const Performance performance;
  const Field field = learn(performance, 300'000);
  std::vector<double> psnrs;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    psnrs.push_back(psnr_of(field, performance.motion));
  }
  hwy::SetSupportedTargetsForTest(0);
  ASSERT_GT(psnrs.size(), 1U);
  const auto [least, most] = std::minmax_element(psnrs.begin(), psnrs.end());
  EXPECT_LT(*most - *least, 0.1);
}

TEST(BentLayer, HasTheSameBitsOnAnyNumberOfThreads) {
  const Performance performance;
  const Camera camera = sheet_frame(0, 0).camera;
  std::vector<Field> fields;
  std::vector<Picture> pictures;
  for (const int threads : {1, 2, 7}) {
    set_thread_count(threads);
    fields.push_back(learn(performance, 40'000));
    pictures.push_back(draw(fields.back(), performance.motion, camera));
  }
  set_thread_count(0);
  EXPECT_GT(opaque_pixels(pictures[0]), 0U);
  for (const std::size_t other : {1, 2}) {
    EXPECT_EQ(fields[other].table, fields[0].table);
    EXPECT_EQ(fields[other].density_net, fields[0].density_net);
    EXPECT_EQ(fields[other].color_net, fields[0].color_net);
    EXPECT_EQ(fields[other].occupancy.words(), fields[0].occupancy.words());
    EXPECT_TRUE(std::ranges::equal(pictures[other].color.values(), pictures[0].color.values()));
    EXPECT_TRUE(std::ranges::equal(pictures[other].depth.values(), pictures[0].depth.values()));
  }
}

TEST(BentLayer, MayHaveACameraInItBehindItOrTurnedAway) {
  const Performance performance;
  const DrawableField drawable(learn(performance, 100'000), performance.motion.graph().get());
  const PosedField posed = pose(drawable, performance.motion.warp(kHeldOutFrame));
  Camera camera = sheet_frame(0, 0).camera;
  const auto seen_from = [&](double z, bool forward) {
    camera.camera_to_world = SE3::Identity();
    camera.camera_to_world.translate(Eigen::Vector3d(0, 0, z));
    if (!forward) camera.camera_to_world.rotate(Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitY()));
    const Picture picture = render({&posed, 1}, camera);
    EXPECT_TRUE(std::ranges::all_of(picture.depth.values(), [](float d) { return d >= 0 && d < 10; })) << z;
    return opaque_pixels(picture);
  };
  const std::size_t front = seen_from(1, true);
  EXPECT_GT(front, 0U);
  EXPECT_EQ(seen_from(1, false), 0U);
  EXPECT_EQ(seen_from(3, true), 0U);
  // From behind it hides about as much as from as far before it.
  EXPECT_NEAR(static_cast<double>(seen_from(3, false)) / static_cast<double>(front), 1, 0.3);
  for (double z = kDistance - 0.1; z < kDistance + 0.1; z += 0.01) {
    seen_from(z, true);
    seen_from(z, false);
  }
}

TEST(BentLayer, IsDrawnInOnePixelAndInManyMillions) {
  const Performance performance;
  const Field field = learn(performance, 40'000);
  for (const int side : {1, 8192}) {
    Camera camera;
    camera.intrinsics = {side, side, 1.0 * side, 1.0 * side, (side - 1) / 2.0, (side - 1) / 2.0};
    const Picture picture = draw(field, performance.motion, camera);
    EXPECT_EQ(picture.color.at(side / 2, side / 2, 3), 255);
    EXPECT_NEAR(picture.depth.at(side / 2, side / 2), kDistance, 0.05);
  }
}

} // namespace
} // namespace kinora::fields
