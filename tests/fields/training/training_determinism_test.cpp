#include <gtest/gtest.h>

#include "core/parallel.h"
#include "fields/scenes/analytic_scene.h"
#include "fields/training/trainer.h"

namespace kinora::fields {
namespace {

class EitherGeometry : public ::testing::TestWithParam<Geometry> {};

INSTANTIATE_TEST_SUITE_P(Training, EitherGeometry, ::testing::Values(Geometry::kDensity, Geometry::kSignedDistance),
                         [](const auto& geometry) { return name_of(geometry.param); });

TEST_P(EitherGeometry, GivesTheSameBitsOnAnyNumberOfThreads) {
  const PixelStore store = store_of(Scene{});
  const auto still = motion::Motion::still();
  FieldConfig config = choose_field_config({store, 2, still});
  config.geometry = GetParam();
  TrainerConfig trainer = short_training();
  trainer.rays = 40'000;
  trainer.quantisation.begin = 0.5;
  Progress progress;
  std::vector<Field> fields;
  for (const int threads : {1, 2, 7}) {
    set_thread_count(threads);
    fields.push_back(train_field({store, 2, still}, config, trainer, progress));
  }
  set_thread_count(0);
  for (const std::size_t other : {1, 2}) {
    EXPECT_EQ(fields[0].table, fields[other].table);
    EXPECT_EQ(fields[0].color_net, fields[other].color_net);
    EXPECT_EQ(fields[0].sharpness, fields[other].sharpness);
    EXPECT_EQ(fields[0].occupancy.words(), fields[other].occupancy.words());
  }
}

} // namespace
} // namespace kinora::fields
