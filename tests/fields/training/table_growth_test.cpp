// Tables grow where the texture asks for it, and only there.
#include <gtest/gtest.h>

#include "core/metrics.h"
#include "core/random.h"
#include "fields/model/grid_vertex.h"
#include "fields/rendering/renderer.h"
#include "fields/scenes/analytic_scene.h"
#include "fields/scenes/random_field.h"
#include "fields/training/table_growth.h"

namespace kinora::fields {
namespace {

/// A wall whose colour is another in every square of `texel` metres; even if that is 0.
struct Wall {
  double texel;

  ingest::Frame frame(int index, double angle) const {
    Scene scene;
    scene.radius = 0;
    ingest::Frame frame = scene.frame(index, angle);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const Eigen::Vector3d p =
            frame.camera.camera_to_world * frame.camera.intrinsics.unproject(u, v, frame.depth.at(u, v));
        const auto column = texel > 0 ? static_cast<std::int64_t>(std::floor(p.x() / texel)) : 0;
        const auto row = texel > 0 ? static_cast<std::int64_t>(std::floor(p.y() / texel)) : 0;
        const std::uint64_t colors = mix64(static_cast<std::uint64_t>(1000 * row + column));
        for (int c = 0; c < 3; ++c) frame.color.at(u, v, c) = static_cast<std::uint8_t>(colors >> (8 * c));
      }
    }
    return frame;
  }
};

struct TrainedField {
  TrainingReport report;
  int log2_table_size;
  double psnr; ///< of a view that was not trained on
};

TrainedField learn(const Wall& wall, int log2_table_size, int largest) {
  PixelStore store(1'000'000, 12);
  for (int i = 0; i < 12; ++i) store.add(wall.frame(i, 0.05 * (i - 6)), i);
  const auto still = motion::Motion::still();
  FieldConfig config = choose_field_config({store, 0, still});
  config.log2_table_size = log2_table_size;
  TrainerConfig trainer = short_training();
  trainer.rays = 400'000;
  trainer.max_log2_table_size = largest;
  TrainedField trained{};
  Progress progress;
  const DrawableField field(train_field({store, 0, still}, config, trainer, progress, &trained.report));
  trained.log2_table_size = field.field().config.log2_table_size;
  const ingest::Frame held_out = wall.frame(0, 0.125);
  const PosedField posed = pose(field, motion::Warp(SE3::Identity()));
  trained.psnr = compare_images(render({&posed, 1}, held_out.camera).color, held_out.color).psnr_full;
  return trained;
}

TEST(TableGrowth, DrawsFineTextureBetter) {
  const Wall wall{0.1};
  const TrainedField fixed = learn(wall, 8, 8);
  const TrainedField free = learn(wall, 8, 17);
  EXPECT_TRUE(fixed.report.table_growth.empty());
  EXPECT_EQ(fixed.log2_table_size, 8);
  EXPECT_GT(free.log2_table_size, 8);
  EXPECT_GT(free.psnr, fixed.psnr + 0.7);
  for (const TableGrowthTrial& trial : free.report.table_growth) {
    EXPECT_GT(trial.grown_bytes, trial.bytes);
    EXPECT_GT(trial.discarded_rays, 0U);
    EXPECT_TRUE(!trial.kept || trial.grown_error < trial.error);
  }
}

TEST(TableGrowth, DoesNotHappenWhereNothingIsGained) {
  const TrainedField even = learn({0}, 8, 17);
  EXPECT_EQ(even.log2_table_size, 8);
  const TrainedField coarse = learn({0.8}, 11, 17);
  EXPECT_FALSE(coarse.report.table_growth.empty()) << "it was not tried";
  EXPECT_EQ(coarse.log2_table_size, 11);
}

TEST(TableGrowth, KeepsWhatEachVertexHolds) {
  for (const int log2_table_size : {6, 10, 12}) { // doubling makes no, one, and another level of this field dense
    FieldConfig config;
    config.levels = 4;
    config.log2_table_size = log2_table_size;
    config.coarsest_resolution = 4;
    config.finest_resolution = 32;
    Field field(config);
    Random random(3);
    for (float& value : field.table) value = random.uniform();
    const Field larger = with_doubled_tables(field);
    EXPECT_GT(larger.table.size(), field.table.size());
    const auto levels = grid_levels(field.config);
    const auto larger_levels = grid_levels(larger.config);
    for (std::size_t l = 0; l < levels.size(); ++l) {
      for (int k = 0; k < 200; ++k) {
        const auto n = static_cast<std::uint32_t>(levels[l].resolution) + 1;
        const std::uint32_t x = random.below(n);
        const std::uint32_t y = random.below(n);
        const std::uint32_t z = random.below(n);
        const std::size_t before = levels[l].offset + vertex_entry(levels[l], x, y, z);
        const std::size_t after = larger_levels[l].offset + vertex_entry(larger_levels[l], x, y, z);
        EXPECT_EQ(field.table[before * FieldConfig::kFeatures], larger.table[after * FieldConfig::kFeatures]);
      }
    }
  }
}

// Larger tables draw the same: their first step moves the nets and the sharpness as the step without them would have.
TEST(TableGrowth, KeepsTheMomentumOfWhatDoesNotGrow) {
  const auto rays_of = [](std::size_t step) {
    return StepRays{1, [step](std::size_t, RayBatch& batch) { batch = testing::random_rays(step, 50); }};
  };
  Field field = testing::random_field(5, 0.5F, Geometry::kSignedDistance);
  FieldOptimizer optimizer(field, {});
  optimizer.draw(rays_of(0));
  for (std::size_t step = 1; step <= 5; ++step) optimizer.step({}, rays_of(step));
  Field larger = with_doubled_tables(field);
  const float sharpness = field.sharpness;
  FieldOptimizer grown(larger, optimizer);
  grown.draw(rays_of(5));
  optimizer.step({}, {});
  grown.step({}, {});
  EXPECT_NE(field.sharpness, sharpness);
  EXPECT_EQ(larger.sharpness, field.sharpness);
  EXPECT_EQ(larger.density_net, field.density_net);
  EXPECT_EQ(larger.color_net, field.color_net);
}

} // namespace
} // namespace kinora::fields
