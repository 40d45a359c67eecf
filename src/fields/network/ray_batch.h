// What one training step sees: rays with their samples and their targets.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fields/network/vector_features.h"

namespace kinora::fields {

/// One point of a ray. Samples of a ray are in order of depth.
struct RaySample {
  std::array<float, 3> position; ///< relative to the field's box, in [0, 1]³
  float depth;                   ///< metres along the optical axis of the ray's camera
  float length;                  ///< of the piece of ray that it stands for, in units of the field's density_length()
};

struct RayTarget {
  std::array<float, 3> color{};    ///< sRGB in [0, 1]
  float depth = 0;                 ///< metres; 0: not measured here
  float inverse_band = 0;          ///< 1 / (metres within which the surface is expected around `depth`)
  float lengths_per_depth = 0;     ///< units of length (RaySample) of the ray for each metre of depth
  Rotation rotation = kNoRotation; ///< of the surface
  bool foreground = true;          ///< false: the pixel shows something behind; all samples should be empty
};

/// Rays of one step. Ray r has samples first_sample[r] … first_sample[r + 1] − 1; it may have none.
struct RayBatch {
  std::vector<RaySample> samples;
  std::vector<std::uint32_t> first_sample{0};
  std::vector<RayTarget> targets;

  std::size_t ray_count() const { return targets.size(); }
  /// The samples appended since the last ray are those of one with this target.
  void end_ray(const RayTarget& target) {
    targets.push_back(target);
    first_sample.push_back(static_cast<std::uint32_t>(samples.size()));
  }
  void clear() {
    samples.clear();
    first_sample.assign(1, 0);
    targets.clear();
  }
};

} // namespace kinora::fields
