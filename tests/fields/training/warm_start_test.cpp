#include <gtest/gtest.h>

#include "core/error.h"
#include "core/metrics.h"
#include "core/parallel.h"
#include "fields/rendering/renderer.h"
#include "fields/scenes/analytic_scene.h"

namespace kinora::fields {
namespace {

constexpr int kWall = 0;
constexpr int kHeldOut = 10; // shows much of the wall that the first views do not

/// Every view but one, from the first on: so many have arrived.
PixelStore arrived(const Scene& scene, int count) {
  PixelStore store(1'000'000, 12);
  for (int i = 0; i < count; ++i) {
    if (i != kHeldOut) store.add(scene.frame(i, 0.1 * (i - 6)), i);
  }
  return store;
}

/// Over the wall, on black where it is not drawn.
double held_out_psnr(const Scene& scene, const Field& field) {
  const ingest::Frame truth = scene.frame(kHeldOut, 0.1 * (kHeldOut - 6));
  const DrawableField drawable(field);
  const PosedField posed{&drawable, SE3::Identity(), nullptr};
  const Picture picture = render({&posed, 1}, truth.camera);
  LabelImage wall(kWidth, kHeight);
  ColorImage shown(kWidth, kHeight, 3);
  for (std::size_t i = 0; i < wall.pixel_count(); ++i) {
    wall.data()[i] = truth.labels.data()[i] == kWall ? 1 : 0;
    for (std::size_t c = 0; c < 3; ++c) {
      shown.data()[3 * i + c] =
          static_cast<std::uint8_t>(picture.color.data()[4 * i + c] * picture.color.data()[4 * i + 3] / 255);
    }
  }
  return psnr_over(shown, truth.color, wall).value_or(0);
}

class WarmStart : public ::testing::TestWithParam<Geometry> {
protected:
  void SetUp() override {
    config = choose_field_config({all, kWall, still});
    config.geometry = GetParam();
    trainer.rays = 300'000;
    before = train_field({arrived(scene, 6), kWall, still}, config, trainer, progress);
    trainer.rays = 30'000;
  }
  void TearDown() override { set_thread_count(0); }

  Scene scene;
  PixelStore all = arrived(scene, 12);
  motion::Motion still = motion::Motion::still();
  FieldConfig config;
  TrainerConfig trainer = short_training();
  Progress progress;
  Field before;
};

INSTANTIATE_TEST_SUITE_P(Training, WarmStart, ::testing::Values(Geometry::kDensity, Geometry::kSignedDistance),
                         [](const auto& geometry) { return name_of(geometry.param); });

TEST_P(WarmStart, LearnsFramesThatArriveWithATenthOfTheRays) {
  const Field cold = train_field({all, kWall, still}, config, trainer, progress);
  const Field warm = train_field({all, kWall, still}, config, trainer, progress, nullptr, &before);
  EXPECT_GT(held_out_psnr(scene, warm), held_out_psnr(scene, cold) + 1);
  EXPECT_GT(held_out_psnr(scene, warm), held_out_psnr(scene, before) + 10);
}

TEST_P(WarmStart, HasTheSameBitsOnAnyNumberOfThreads) {
  std::vector<Field> fields;
  for (const int threads : {1, 2, 7}) {
    set_thread_count(threads);
    fields.push_back(train_field({all, kWall, still}, config, trainer, progress, nullptr, &before));
  }
  for (const std::size_t other : {1, 2}) {
    EXPECT_EQ(fields[0].table, fields[other].table);
    EXPECT_EQ(fields[0].color_net, fields[other].color_net);
    EXPECT_EQ(fields[0].occupancy.words(), fields[other].occupancy.words());
  }
}

TEST_P(WarmStart, RefusesAFieldOfAnotherConfiguration) {
  FieldConfig other = config;
  other.finest_resolution += 1;
  EXPECT_THROW(train_field({all, kWall, still}, other, trainer, progress, nullptr, &before), Error);
}

} // namespace
} // namespace kinora::fields
