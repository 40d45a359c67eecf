// Density bricks and the march through them, against the field and against a plain loop, on every instruction set.
#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "fields/network/field_batch.h"
#include "fields/network/ray_batch.h"
#include "fields/rendering/ray_marching.h"
#include "fields/scenes/painted_field.h"
#include "fields/scenes/random_field.h"
#include "support/every_instruction_set.h"

namespace kinora::fields {
namespace {

/// A random field in a corner of which every other block of cells is occupied.
Field patchy_field() {
  Field field = testing::random_field(3, 2.0F);
  for (int z = 0; z < 24; ++z) {
    for (int y = 0; y < 24; ++y) {
      for (int x = 0; x < 24; ++x) field.occupancy.set(x, y, z, ((x / 8 + y / 8 + z / 8) & 1) != 0);
    }
  }
  return field;
}

std::vector<MarchRay> random_rays(int count, float side) {
  Random random(7);
  std::vector<MarchRay> rays;
  for (int i = 0; i < count; ++i) {
    MarchRay ray{};
    for (std::size_t a = 0; a < 3; ++a) {
      ray.origin[a] = side * random.uniform();
      ray.direction[a] = static_cast<float>(random.normal());
    }
    const float norm = std::hypot(ray.direction[0], ray.direction[1], ray.direction[2]);
    for (float& d : ray.direction) d /= norm;
    rays.push_back(ray);
  }
  return rays;
}

/// march() for one ray, plainly.
MarchRun march_plainly(const DensityBricks& bricks, const MarchRay& ray, float begin, float optical_length) {
  MarchRun run;
  double transmittance = 1;
  double weighted = 0;
  double squared = 0;
  double median = -1;
  float step = begin;
  for (;; ++step) {
    std::array<float, 3> at{};
    for (std::size_t a = 0; a < 3; ++a) at[a] = ray.origin[a] + (step + 0.5F) * ray.direction[a];
    const auto brick = [&at](std::size_t a) { return static_cast<int>(std::floor(at[a] / DensityBricks::kSide)); };
    if (bricks.brick_at(brick(0), brick(1), brick(2)) < 0) break;
    const double step_transmittance = std::exp(-std::exp(bricks.raw_density(at)) * optical_length);
    const double weight = transmittance * (1 - step_transmittance);
    const double where = step - begin + 0.5;
    weighted += weight * where;
    squared += weight * where * where;
    if (transmittance > 0.5 && transmittance - weight <= 0.5) median = step + 0.5;
    transmittance -= weight;
    if (transmittance <= kOpaque) run.reason = RunEnd::kOpaque;
    if (run.reason == RunEnd::kLeft && step_transmittance > 1 - kRunEnds && transmittance < 1 - kRunBegins) {
      run.reason = RunEnd::kGap;
    }
    if (run.reason == RunEnd::kLeft) continue;
    ++step;
    break;
  }
  run.end = step;
  run.opacity = static_cast<float>(1 - transmittance);
  const double mean = weighted / std::max(1 - transmittance, 1e-12);
  run.mean = static_cast<float>(begin + mean);
  run.median = median < 0 ? run.mean : static_cast<float>(median);
  run.sigma = static_cast<float>(std::sqrt(std::max(squared / std::max(1 - transmittance, 1e-12) - mean * mean, 0.0)));
  return run;
}

class March : public OnEveryInstructionSet {};

TEST_P(March, EqualsAPlainLoop) {
  const DensityBricks bricks(patchy_field());
  ASSERT_GT(bricks.count(), 20U);
  const std::vector<MarchRay> rays = random_rays(1003, 0.4F * static_cast<float>(bricks.resolution()));
  for (const float optical_length : {0.02F, 0.25F}) {
    std::vector<float> begin(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) begin[i] = static_cast<float>(i % 3);
    std::vector<MarchRun> runs(rays.size());
    march(bricks, rays.data(), begin.data(), rays.size(), optical_length, runs.data());
    std::size_t other_ends = 0; // decisions that rounding may turn
    std::size_t other_medians = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const MarchRun expected = march_plainly(bricks, rays[i], begin[i], optical_length);
      if (runs[i].reason != expected.reason || runs[i].end != expected.end) {
        ++other_ends;
        continue;
      }
      EXPECT_NEAR(runs[i].opacity, expected.opacity, 1e-4F);
      if (expected.opacity < 1e-3F) continue;
      EXPECT_NEAR(runs[i].mean, expected.mean, 0.01F);
      if (std::abs(expected.opacity - 0.5F) > 0.01F)
        other_medians += std::abs(runs[i].median - expected.median) > 0.01F ? 1 : 0;
      EXPECT_NEAR(runs[i].sigma, expected.sigma, 0.05F);
    }
    EXPECT_LE(other_ends, rays.size() / 200);
    EXPECT_LE(other_medians, rays.size() / 200);
  }
}

TEST_P(March, RaysThatAreNoNumberOrOutsideMeetNothing) {
  const DensityBricks bricks(patchy_field());
  const float nan = std::nanf("");
  const std::vector<MarchRay> rays{{{nan, 4, 4}, {1, 0, 0}},
                                   {{4, 4, 4}, {nan, 0, 0}},
                                   {{-50, 4, 4}, {1, 0, 0}},
                                   {{4, 4, 1e30F}, {1, 0, 0}},
                                   {{4, 4, 4}, {1e30F, 0, 0}}};
  const std::vector<float> begin(rays.size(), 0);
  std::vector<MarchRun> runs(rays.size());
  march(bricks, rays.data(), begin.data(), rays.size(), 0.25F, runs.data());
  for (const MarchRun& run : runs) {
    EXPECT_EQ(run.reason, RunEnd::kLeft);
    EXPECT_EQ(run.opacity, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, March, every_instruction_set(), name_of_set);

TEST(DensityBricks, HoldTheFieldsDensity) {
  const Field field = testing::painted_field({Eigen::Vector3d::Constant(-0.5), 1}, testing::PaintedBall{});
  const DensityBricks bricks(field);
  const std::vector<GridLevel> levels = grid_levels(field.config);
  Random random(4);
  std::vector<float> x, y, z;
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector3d direction = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    const Eigen::Vector3d p = Eigen::Vector3d::Constant(0.5) + (0.28 + 0.04 * random.uniform_double()) * direction;
    x.push_back(static_cast<float>(p.x()));
    y.push_back(static_cast<float>(p.y()));
    z.push_back(static_cast<float>(p.z()));
  }
  PointBatch points;
  evaluate_points(field, levels, {x.data(), y.data(), z.data(), x.size()}, points);
  const auto scale = static_cast<float>(bricks.resolution());
  double sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const float found = bricks.raw_density({x[i] * scale, y[i] * scale, z[i] * scale});
    sum += std::abs(found - points.geometry[i * FieldConfig::kGeometry]);
  }
  // The lattice is as fine as the field, but shifted by half a cell: kinks are cut.
  EXPECT_LT(sum / static_cast<double>(x.size()), 0.6);
}

TEST(DensityBricks, OfAnEmptyFieldAreNone) {
  const Field field(testing::small_config());
  const DensityBricks bricks(field);
  EXPECT_EQ(bricks.count(), 0U);
  EXPECT_EQ(bricks.raw_density({3, 3, 3}), DensityBricks::kLowest);
}

} // namespace
} // namespace kinora::fields
