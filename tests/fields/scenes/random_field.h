// Fields and rays with random contents, for tests of the mathematics.
#pragma once

#include "core/random.h"
#include "fields/model/field.h"
#include "fields/network/ray_batch.h"

namespace kinora::fields::testing {

inline FieldConfig small_config() {
  FieldConfig config;
  config.levels = 4;
  config.log2_table_size = 9;
  config.coarsest_resolution = 4; // dense; the finer levels are hashed
  config.finest_resolution = 40;
  config.occupancy_resolution = 64;
  return config;
}

inline Field random_field(std::uint64_t seed, float table_scale = 0.5F, Geometry geometry = Geometry::kDensity) {
  FieldConfig config = small_config();
  config.geometry = geometry;
  Field field(config);
  if (geometry == Geometry::kSignedDistance) field.sharpness = 0.8F;
  Random random(seed);
  for (float& v : field.table) v = table_scale * static_cast<float>(random.normal());
  for (float& v : field.density_net) v = 0.3F * static_cast<float>(random.normal());
  for (float& v : field.color_net) v = 0.3F * static_cast<float>(random.normal());
  return field;
}

inline Rotation random_rotation(Random& random) {
  Eigen::Vector4f q;
  for (float& x : q) x = random.uniform() - 0.5F;
  q.normalize();
  return {q[0], q[1], q[2], q[3]};
}

/// Rays with 0 to 9 samples, here and there or, every other ray, close to each other; own ones with and without depth,
/// and rays of other layers.
inline RayBatch random_rays(std::uint64_t seed, std::size_t count) {
  RayBatch batch;
  Random random(seed);
  for (std::size_t r = 0; r < count; ++r) {
    const std::uint32_t samples = random.below(10);
    float depth = 1;
    const std::array<float, 3> start{random.uniform(), random.uniform(), random.uniform()};
    for (std::uint32_t i = 0; i < samples; ++i) {
      depth += 0.01F + 0.02F * random.uniform();
      std::array<float, 3> position = start;
      for (float& x : position) x = r % 2 == 0 ? random.uniform() : x + 0.01F * random.uniform();
      batch.samples.push_back({position, depth, 0.1F + 0.5F * random.uniform()});
    }
    batch.first_sample.push_back(static_cast<std::uint32_t>(batch.samples.size()));
    RayTarget target;
    target.foreground = random.below(4) != 0;
    if (random.below(4) != 0) {
      target.depth = 1.1F;
      target.inverse_band = 1 / 0.07F;
      target.lengths_per_depth = 9;
    }
    for (float& c : target.color) c = random.uniform();
    target.rotation = random_rotation(random);
    batch.targets.push_back(target);
  }
  return batch;
}

} // namespace kinora::fields::testing
