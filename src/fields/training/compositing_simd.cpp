#include "fields/training/compositing.h"

#include "fields/network/volume_density.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/training/compositing_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>
// after highway.h
#include "fields/training/loss_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kG = FieldConfig::kGeometry;

/// A row of geometry, or of inputs of the colour MLP, in as many vectors as the instruction set needs.
using RowTag = hn::CappedTag<float, kG>;
constexpr std::size_t kRowLanes = hn::MaxLanes(RowTag());
constexpr std::size_t kRowVectors = kG / kRowLanes;

/// Rows of geometry begin with the raw density, rows of inputs end with the constant 1: this is what moves the 15
/// features between them by one.
struct ShiftedRow {
  HWY_ALIGN float values[kG + 16] = {};
};

void composite(const RayBatch& rays, const float* geometry, const LossWeights& weights, Composition& c, float* inputs) {
  const RowTag d;
  ShiftedRow shifted;
  float* input = inputs;
  for (std::size_t r = 0; r < rays.ray_count(); ++r) {
    const RayTarget& target = rays.targets[r];
    const bool has_depth = target.foreground && target.depth > 0;
    float transmittance = 1;
    float depth_loss = 0;
    hn::Vec<RowTag> features[kRowVectors];
    for (auto& f : features) f = hn::Zero(d);
    for (std::size_t i = rays.first_sample[r]; i < rays.first_sample[r + 1]; ++i) {
      const float behind = transmittance * c.transmittance[i];
      const float weight = transmittance - behind;
      c.transmittance[i] = transmittance = behind;
      c.weight[i] = weight;
      const auto row_weight = hn::Set(d, weight);
      for (std::size_t v = 0; v < kRowVectors; ++v) {
        features[v] = hn::MulAdd(row_weight, hn::LoadU(d, geometry + i * kG + v * kRowLanes), features[v]);
      }
      c.depth_term[i] = has_depth ? depth_term(rays.samples[i].depth, target, weights) : 0.0F;
      depth_loss += weight * c.depth_term[i];
    }
    const float opacity = c.opacity[r] = 1 - transmittance;
    if (!target.foreground) {
      c.loss += static_cast<double>(free_space_term(opacity, weights));
      continue;
    }
    c.loss += static_cast<double>(opacity_term(transmittance, weights) + weights.depth * depth_loss);
    c.foreground_opacity += static_cast<double>(opacity);
    ++c.foreground_rays;
    const auto normaliser = hn::Set(d, 1.0F / (opacity + kOpacityEpsilon));
    for (std::size_t v = 0; v < kRowVectors; ++v) {
      hn::Store(hn::Mul(features[v], normaliser), d, shifted.values + v * kRowLanes);
    }
    shifted.values[kG] = 1;
    for (std::size_t v = 0; v < kRowVectors; ++v) {
      hn::StoreU(hn::LoadU(d, shifted.values + 1 + v * kRowLanes), d, input + v * kRowLanes);
    }
    input += kG;
  }
}

void composite_backward(const RayBatch& rays, const float* geometry, const LossWeights& weights, float scale,
                        const Composition& c, const float* inputs, const float* input_gradient,
                        float* geometry_gradient) {
  const RowTag d;
  HWY_ALIGN float features[kG]; // 1 where a row of inputs holds a feature
  std::fill_n(features, kG, 1.0F);
  features[kG - 1] = 0;
  ShiftedRow shifted; // the first element belongs to no feature and stays zero
  for (std::size_t r = 0; r < rays.ray_count(); ++r) {
    const RayTarget& target = rays.targets[r];
    float by_opacity = free_space_gradient(scale, weights);
    hn::Vec<RowTag> feature_gradient[kRowVectors];
    for (auto& g : feature_gradient) g = hn::Zero(d);
    if (target.foreground) {
      const auto normaliser = hn::Set(d, 1.0F / (c.opacity[r] + kOpacityEpsilon));
      auto along = hn::Zero(d);
      for (std::size_t v = 0; v < kRowVectors; ++v) {
        const std::size_t at = v * kRowLanes;
        const auto g = hn::Mul(hn::Mul(hn::LoadU(d, input_gradient + at), normaliser), hn::Load(d, features + at));
        along = hn::MulAdd(g, hn::LoadU(d, inputs + at), along);
        hn::StoreU(g, d, shifted.values + 1 + at);
      }
      for (std::size_t v = 0; v < kRowVectors; ++v) {
        feature_gradient[v] = hn::Load(d, shifted.values + v * kRowLanes);
      }
      by_opacity = opacity_gradient(scale, 1 - c.opacity[r], weights) - hn::GetLane(hn::SumOfLanes(d, along));
      inputs += kG;
      input_gradient += kG;
    }
    float behind = 0; // Σ over the samples behind of weight · its gradient
    for (std::size_t i = rays.first_sample[r + 1]; i-- > rays.first_sample[r];) {
      const float* g = geometry + i * kG;
      float* out = geometry_gradient + i * kG;
      auto along = hn::Zero(d);
      for (std::size_t v = 0; v < kRowVectors; ++v) {
        along = hn::MulAdd(feature_gradient[v], hn::LoadU(d, g + v * kRowLanes), along);
        hn::StoreU(hn::Mul(hn::Set(d, c.weight[i]), feature_gradient[v]), d, out + v * kRowLanes);
      }
      const float weight_gradient =
          by_opacity + scale * weights.depth * c.depth_term[i] + hn::GetLane(hn::SumOfLanes(d, along));
      out[0] = c.density[i] * rays.samples[i].length * (c.transmittance[i] * weight_gradient - behind);
      behind += c.weight[i] * weight_gradient;
    }
  }
}

} // namespace kinora::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::fields {

HWY_EXPORT(composite);
HWY_EXPORT(composite_backward);
HWY_EXPORT(compare_colors);

void composite(const RayBatch& rays, const std::vector<float>& lengths, const float* geometry,
               const LossWeights& weights, Composition& composition, std::vector<float>& inputs) {
  const std::size_t n = rays.samples.size();
  for (std::vector<float>* values :
       {&composition.weight, &composition.transmittance, &composition.density, &composition.depth_term}) {
    values->resize(n);
  }
  composition.opacity.resize(rays.ray_count());
  composition.foreground_rays = 0;
  composition.foreground_opacity = composition.loss = 0;
  inputs.resize(rays.ray_count() * FieldConfig::kGeometry);
  kernels::densities(geometry, lengths.data(), n, composition.density.data(), composition.transmittance.data());
  HWY_DYNAMIC_DISPATCH(composite)(rays, geometry, weights, composition, inputs.data());
}

void composite_backward(const RayBatch& rays, const float* geometry, const LossWeights& weights, float scale,
                        const Composition& composition, const std::vector<float>& inputs, const float* input_gradient,
                        float* geometry_gradient) {
  HWY_DYNAMIC_DISPATCH(composite_backward)
  (rays, geometry, weights, scale, composition, inputs.data(), input_gradient, geometry_gradient);
}

ColorSums compare_colors(const RayBatch& rays, const float* outputs, const LossWeights& weights, float scale,
                         std::vector<float>& gradient) {
  gradient.assign(rays.ray_count() * FieldConfig::kColorOutputs, 0.0F);
  return HWY_DYNAMIC_DISPATCH(compare_colors)(rays, outputs, weights, scale, gradient.data());
}

} // namespace kinora::fields
#endif
