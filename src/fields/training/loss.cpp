#include "fields/training/loss.h"

#include <cmath>

#include "fields/model/field.h"

namespace kinora::fields {

void ColorSums::add(const ColorSums& other) {
  squared_error += other.squared_error;
  squared_target += other.squared_target;
  for (std::size_t c = 0; c < 3; ++c) target[c] += other.target[c];
}

double distance_loss(const RayBatch& rays, const std::vector<float>& distances, const LossWeights& weights, float scale,
                     float* geometry_gradient) {
  double loss = 0;
  for (std::size_t r = 0; r < rays.ray_count(); ++r) {
    const RayTarget& target = rays.targets[r];
    if (!target.foreground || !(target.depth > 0)) continue;
    const float per_distance = target.inverse_band / target.lengths_per_depth;
    for (std::size_t i = rays.first_sample[r]; i < rays.first_sample[r + 1]; ++i) {
      const float measured = (target.depth - rays.samples[i].depth) * target.inverse_band;
      if (std::abs(measured) > 1) continue;
      const float residual = distances[i] * per_distance - measured;
      loss += static_cast<double>(weights.distance * residual * residual);
      geometry_gradient[i * FieldConfig::kGeometry] += scale * 2 * weights.distance * residual * per_distance;
    }
  }
  return loss;
}

} // namespace kinora::fields
