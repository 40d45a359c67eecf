// The loss of one ray and its gradient by every parameter, written once and plainly, for any scalar type: what
// compositing.h and loss.h are tested against, and whose gradients are checked numerically in double.
// A ray (Max 1995; Mildenhall et al. 2020): αᵢ = 1 − exp(−σᵢ δᵢ), wᵢ = αᵢ Πⱼ<ᵢ (1 − αⱼ), A = Σ wᵢ, F = Σ wᵢ gᵢ; colour
// = sigmoid(MLP([R F / (A + ε), 1])), where R turns the vectors among the features as the layer is turned
// (vector_features.h).
#pragma once

#include <span>
#include <vector>

#include "fields/network/reference.h"
#include "fields/network/volume_density.h"
#include "fields/training/loss.h"

namespace kinora::fields::reference {

/// How far, in bands, a sample's distance is from what the depth measured on its ray implies, and the derivative. Zero
/// outside of the band.
template <class T> struct DistanceResidual { T value = 0, by_distance = 0; };
template <class T> DistanceResidual<T> distance_residual(T distance, const RaySample& sample, const RayTarget& target) {
  if (!target.foreground || !(target.depth > 0)) return {};
  const T measured = (T(target.depth) - T(sample.depth)) * T(target.inverse_band);
  if (std::abs(measured) > T(1)) return {};
  const T per_distance = T(target.inverse_band) / T(target.lengths_per_depth);
  return {distance * per_distance - measured, per_distance};
}

/// Loss of one ray (see LossWeights); adds scale · its gradient to `gradient` if that is given.
template <class T>
T ray_loss(const FieldConfig& config, std::span<const GridLevel> levels, const Parameters<T>& p,
           std::span<const RaySample> samples, const RayTarget& target, const LossWeights& weights, T scale,
           Parameters<T>* gradient) {
  const std::size_t n = samples.size();
  std::vector<array<T, 3>> positions(n);
  std::vector<PointState<T>> points(n);
  std::vector<T> weight(n), transmittance(n + 1, T(1)), depth_terms(n, T(0));
  array<T, kG> features{};
  T opacity = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (int a = 0; a < 3; ++a) positions[i][a] = T(samples[i].position[a]);
    points[i] = evaluate_point<T>(config, levels, p, positions[i]);
    transmittance[i + 1] = transmittance[i] * std::exp(-density(points[i].geometry[0]) * T(samples[i].length));
    weight[i] = transmittance[i] - transmittance[i + 1];
    opacity += weight[i];
    for (int f = 1; f < kG; ++f) features[f - 1] += weight[i] * points[i].geometry[f];
    if (target.foreground && target.depth > 0) {
      depth_terms[i] = depth_term(T(samples[i].depth), target, weights);
    }
  }

  const bool has_distances = config.geometry == Geometry::kSignedDistance;
  T loss = 0;
  T by_opacity = 0;
  array<T, kG> feature_gradient{};
  if (target.foreground) {
    const T normaliser = T(1) / (opacity + T(kOpacityEpsilon));
    array<T, kG> input{};
    for (int f = 0; f < kG - 1; ++f) input[f] = features[f] * normaliser;
    input[kG - 1] = T(1);
    array<T, kG> rotated = input;
    rotate_vectors(target.rotation, rotated.data());
    const ColorState<T> color = evaluate_color<T>(p.color_net, rotated);
    array<T, 3> color_gradient{};
    for (int c = 0; c < 3; ++c) {
      const T difference = color.color[c] - T(target.color[c]);
      loss += T(weights.color) * difference * difference;
      color_gradient[c] = scale * T(2) * T(weights.color) * difference;
    }
    loss += opacity_term(T(1) - opacity, weights);
    for (std::size_t i = 0; i < n; ++i) {
      loss += T(weights.depth) * weight[i] * depth_terms[i];
      if (!has_distances) continue;
      const T residual = distance_residual(points[i].distance, samples[i], target).value;
      loss += T(weights.distance) * residual * residual;
    }
    if (gradient) {
      array<T, kG> input_gradient = color_backward<T>(p.color_net, color, color_gradient, gradient->color_net);
      rotate_vectors(inverse_rotation(target.rotation), input_gradient.data());
      by_opacity = opacity_gradient(scale, T(1) - opacity, weights);
      for (int f = 0; f < kG - 1; ++f) {
        feature_gradient[f] = input_gradient[f] * normaliser;
        by_opacity -= feature_gradient[f] * input[f];
      }
    }
  } else {
    loss = free_space_term(opacity, weights);
    by_opacity = free_space_gradient(scale, weights);
  }
  if (!gradient) return loss;

  T behind = 0; // Σⱼ>ᵢ wⱼ ∂L/∂wⱼ
  for (std::size_t i = n; i-- > 0;) {
    const auto& g = points[i].geometry;
    T weight_gradient = by_opacity + scale * T(weights.depth) * depth_terms[i];
    array<T, kG> geometry_gradient{};
    for (int f = 1; f < kG; ++f) {
      weight_gradient += feature_gradient[f - 1] * g[f];
      geometry_gradient[f] = weight[i] * feature_gradient[f - 1];
    }
    const T density_gradient = T(samples[i].length) * (transmittance[i + 1] * weight_gradient - behind);
    const T raw_gradient = density_gradient * density(g[0]);
    geometry_gradient[0] = raw_gradient * points[i].by_distance;
    gradient->sharpness += raw_gradient * points[i].by_sharpness;
    if (has_distances) {
      const auto residual = distance_residual(points[i].distance, samples[i], target);
      geometry_gradient[0] += scale * 2 * T(weights.distance) * residual.value * residual.by_distance;
    }
    behind += weight[i] * weight_gradient;
    point_backward<T>(config, levels, p, positions[i], points[i], geometry_gradient, *gradient);
  }
  return loss;
}

} // namespace kinora::fields::reference
