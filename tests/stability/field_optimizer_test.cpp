// Training steps of fields and rays that ordinary training hardly meets.
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "fields/network/flush_to_zero.h"
#include "fields/rendering/renderer.h"
#include "fields/scenes/random_field.h"
#include "fields/training/field_optimizer.h"

namespace kinora::fields {
namespace {

StepRays random_rays_of_step(std::size_t step) {
  return {2, [step](std::size_t c, RayBatch& batch) { batch = testing::random_rays(2 * step + c, 50); }};
}

template <class Values> bool all_finite(const Values& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

void expect_finite(const Field& field) {
  EXPECT_TRUE(all_finite(field.table));
  EXPECT_TRUE(all_finite(field.density_net));
  EXPECT_TRUE(all_finite(field.color_net));
  EXPECT_TRUE(std::isfinite(field.sharpness));
}

/// A field whose raw density, or distance from the surface, is `raw` everywhere.
Field field_of_raw_density(Geometry geometry, float raw) {
  Field field = testing::random_field(5, 0.0F, geometry);
  const auto width = static_cast<std::size_t>(field.config.encoding_width());
  constexpr float kEntry = 100;
  for (float& v : field.table) v = kEntry;
  std::fill(field.density_net.begin(), field.density_net.end(), 0.0F);
  for (std::size_t i = 0; i < width; ++i) field.density_net[i * FieldConfig::kHidden] = 1;
  field.density_net[width * FieldConfig::kHidden] = raw / (kEntry * static_cast<float>(width));
  return field;
}

struct RawCase {
  Geometry geometry;
  float raw;
  bool opaque;
};

class RawDensity : public ::testing::TestWithParam<RawCase> {};

TEST_P(RawDensity, LeavesLossGradientStepAndDrawingFinite) {
  Field field = field_of_raw_density(GetParam().geometry, GetParam().raw);
  std::fill(field.occupancy.words().begin(), field.occupancy.words().end(), ~std::uint64_t{0});
  FieldOptimizer optimizer(field, {});
  FieldOptimizer::Gradient gradient;
  const StepResult result = optimizer.gradient(random_rays_of_step(0), gradient);
  EXPECT_TRUE(std::isfinite(result.loss));
  EXPECT_TRUE(std::isfinite(result.opacity));
  EXPECT_TRUE(all_finite(gradient.table));
  EXPECT_TRUE(all_finite(gradient.density_net));
  EXPECT_TRUE(all_finite(gradient.color_net));
  EXPECT_TRUE(std::isfinite(gradient.sharpness));

  const DrawableField drawable(field);
  const PosedField posed = pose(drawable, motion::Warp(SE3::Identity()));
  Camera camera;
  camera.intrinsics = {32, 24, 30, 30, 15.5, 11.5};
  camera.camera_to_world = SE3::Identity();
  camera.camera_to_world.translation() = Eigen::Vector3d(0.5, 0.5, -1);
  const Picture picture = render({&posed, 1}, camera);
  EXPECT_TRUE(all_finite(picture.depth.values()));
  EXPECT_EQ(picture.color.at(16, 12, 3), GetParam().opaque ? 255 : 0); // all or nothing

  optimizer.draw(random_rays_of_step(0));
  for (std::size_t step = 0; step < 3; ++step) {
    EXPECT_TRUE(std::isfinite(optimizer.step({}, random_rays_of_step(step + 1)).loss));
  }
  expect_finite(field);
}

INSTANTIATE_TEST_SUITE_P(
    OfTenThousand, RawDensity,
    ::testing::Values(RawCase{Geometry::kDensity, 1e4F, true}, RawCase{Geometry::kDensity, -1e4F, false},
                      RawCase{Geometry::kSignedDistance, 1e4F, false}, RawCase{Geometry::kSignedDistance, -1e4F, true}),
    [](const auto& raw) {
      return std::string(name_of(raw.param.geometry)) + (raw.param.opaque ? "_opaque" : "_transparent");
    });

TEST(FieldSteps, OfOtherLayersRaysAloneOnlyEmptyTheField) {
  Field field = testing::random_field(5);
  const std::vector<float> color_net = field.color_net;
  FieldOptimizer optimizer(field, {});
  const auto rays_of = [](std::size_t step) {
    return StepRays{1, [step](std::size_t, RayBatch& batch) {
                      batch = testing::random_rays(step, 100);
                      for (RayTarget& target : batch.targets) target.foreground = false;
                    }};
  };
  optimizer.draw(rays_of(0));
  const double before = optimizer.step({}, rays_of(0)).loss;
  double after = 0;
  for (std::size_t step = 0; step < 100; ++step) after = optimizer.step({}, rays_of(0)).loss;
  EXPECT_LT(after, 0.1 * before);
  EXPECT_EQ(field.color_net, color_net);
  expect_finite(field);
}

TEST(FieldSteps, OfRaysWithoutSamplesAreFinite) {
  Field field = testing::random_field(5);
  const Field before = field;
  FieldOptimizer optimizer(field, {});
  optimizer.draw({1, [](std::size_t, RayBatch& batch) {
                    batch.targets.resize(10);
                    batch.first_sample.resize(11, 0);
                  }});
  EXPECT_TRUE(std::isfinite(optimizer.step({}, {}).loss));
  EXPECT_EQ(field.table, before.table);
  expect_finite(field);
}

TEST(FieldSteps, OfNoRaysAtAllLeaveTheFieldAsItWas) {
  Field field = testing::random_field(5);
  const Field before = field;
  FieldOptimizer optimizer(field, {});
  for (const std::size_t chunks : {0, 2}) {
    const StepRays none{chunks, [](std::size_t, RayBatch& batch) { batch = {}; }};
    optimizer.draw(none);
    const StepResult result = optimizer.step({}, none);
    EXPECT_EQ(result.rays, 0U);
    EXPECT_TRUE(std::isfinite(result.loss));
    EXPECT_TRUE(std::isfinite(result.opacity));
    EXPECT_EQ(field.table, before.table);
    EXPECT_EQ(field.density_net, before.density_net);
    EXPECT_EQ(field.color_net, before.color_net);
  }
}

TEST(FieldSteps, StayFiniteForAMillion) {
  FieldConfig config;
  config.levels = 2;
  config.log2_table_size = 4;
  config.coarsest_resolution = 1;
  config.finest_resolution = 3;
  config.occupancy_resolution = 64;
  Field field(config);
  Random random(3);
  const auto fill = [&random](auto& values) {
    for (float& v : values) v = 0.3F * static_cast<float>(random.normal());
  };
  fill(field.table);
  fill(field.density_net);
  fill(field.color_net);
  FieldOptimizer optimizer(field, {});
  const RayBatch rays = testing::random_rays(1, 3);
  const StepRays given{1, [&rays](std::size_t, RayBatch& batch) { batch = rays; }};
  set_thread_count(1);
  optimizer.draw(given);
  StepResult result;
  for (int step = 0; step < 1'000'000; ++step) result = optimizer.step({}, given);
  set_thread_count(0);
  EXPECT_TRUE(std::isfinite(result.loss));
  expect_finite(field);
}

TEST(FieldSteps, TakeDenormalNumbersForZero) {
  // Parameters, gradients and moments alike: the weights of the loss are so small that all gradients are denormal.
  const auto trained = [](float entry, float weight) {
    Field field = testing::random_field(5);
    for (float& v : field.table) v = std::copysign(entry, v);
    FieldOptimizer optimizer(field, {weight, weight, weight, weight});
    optimizer.draw(random_rays_of_step(0));
    for (std::size_t step = 0; step < 20; ++step) {
      EXPECT_TRUE(std::isfinite(optimizer.step({}, random_rays_of_step(step + 1)).loss));
    }
    expect_finite(field);
    return field;
  };
  EXPECT_EQ(trained(1e-40F, 1).color_net, trained(0, 1).color_net);
  EXPECT_EQ(trained(0.5F, 1e-40F).density_net, testing::random_field(5).density_net);
}

TEST(FieldSteps, FlushDenormalsWhileTheyLastAndNoLonger) {
  volatile float smallest = 1.2e-38F;
  const auto tenth = [&] { return smallest * 0.1F; };
#if defined(__SSE2__)
  {
    const FlushToZero flush;
    EXPECT_EQ(tenth(), 0.0F);
  }
#endif
  Field field = testing::random_field(5);
  FieldOptimizer optimizer(field, {});
  optimizer.draw(random_rays_of_step(0));
  optimizer.step({}, {});
  std::atomic<int> flushing = 0;
  parallel_for(64, 1, [&](const Chunk&) { flushing += tenth() == 0.0F ? 1 : 0; });
  EXPECT_EQ(flushing, 0);
}

} // namespace
} // namespace kinora::fields
