#include "fields/compositing.h"

#include <algorithm>
#include <cmath>

namespace kinora::fields {
namespace {

constexpr std::size_t kG = FieldConfig::kGeometry;
constexpr std::size_t kO = FieldConfig::kColorOutputs;

float sigmoid(float x) { return 1.0F / (1.0F + std::exp(-x)); }

} // namespace

void ChunkCompositor::forward(const RayBatch& rays, const std::vector<float>& lengths, const float* geometry,
                              const LossWeights& weights, ColorBatch& color) {
  const std::size_t n = rays.samples.size();
  weight_.resize(n);
  transmittance_.resize(n);
  density_.resize(n);
  depth_term_.assign(n, 0.0F);
  opacity_.resize(rays.ray_count());
  color.input.resize(rays.ray_count() * kG);
  own_rays_ = 0;
  own_opacity_ = 0;
  kernels::densities(geometry, lengths.data(), n, density_.data(), transmittance_.data());
  for (std::size_t r = 0; r < rays.ray_count(); ++r) {
    const RayTarget& target = rays.targets[r];
    float transmittance = 1;
    float opacity = 0;
    std::array<float, kG> features{};
    for (std::size_t i = rays.first_sample[r]; i < rays.first_sample[r + 1]; ++i) {
      const float* g = geometry + i * kG;
      const float behind = transmittance * transmittance_[i];
      weight_[i] = transmittance - behind;
      transmittance_[i] = transmittance = behind;
      opacity += weight_[i];
      for (std::size_t f = 1; f < kG; ++f) features[f - 1] += weight_[i] * g[f];
      if (target.own && target.depth > 0) {
        const float residual = (rays.samples[i].depth - target.depth) * target.inverse_band;
        depth_term_[i] = std::min(residual * residual, weights.depth_clamp);
      }
    }
    opacity_[r] = opacity;
    if (!target.own) continue;
    float* input = color.input.data() + own_rays_ * kG;
    const float normaliser = 1.0F / (opacity + kOpacityEpsilon);
    for (std::size_t f = 0; f + 1 < kG; ++f) input[f] = features[f] * normaliser;
    input[kG - 1] = 1;
    own_opacity_ += opacity;
    ++own_rays_;
  }
}

double ChunkCompositor::loss(const RayBatch& rays, const LossWeights& weights, float scale, const ColorBatch& color,
                             std::vector<float>& color_gradient) const {
  color_gradient.assign(own_rays_ * kO, 0.0F);
  double sum = 0;
  std::size_t own = 0;
  for (std::size_t r = 0; r < rays.ray_count(); ++r) {
    const RayTarget& target = rays.targets[r];
    if (!target.own) {
      sum += static_cast<double>(weights.emptiness) * opacity_[r];
      continue;
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = sigmoid(color.output[own * kO + c]);
      const float difference = value - target.color[c];
      sum += static_cast<double>(weights.color) * difference * difference;
      color_gradient[own * kO + c] = scale * 2 * weights.color * difference * value * (1 - value);
    }
    const double transparency = 1.0 - opacity_[r];
    sum += weights.opacity * transparency * transparency;
    for (std::size_t i = rays.first_sample[r]; i < rays.first_sample[r + 1]; ++i) {
      sum += static_cast<double>(weights.depth) * weight_[i] * depth_term_[i];
    }
    ++own;
  }
  return sum;
}

void ChunkCompositor::backward(const RayBatch& rays, const float* geometry, const LossWeights& weights, float scale,
                               const ColorBatch& color, const float* input_gradient, float* geometry_gradient) const {
  std::size_t own = 0;
  for (std::size_t r = 0; r < rays.ray_count(); ++r) {
    const RayTarget& target = rays.targets[r];
    float opacity_gradient = scale * weights.emptiness;
    std::array<float, kG> feature_gradient{}; // element 0 belongs to no feature
    if (target.own) {
      const float normaliser = 1.0F / (opacity_[r] + kOpacityEpsilon);
      opacity_gradient = -scale * 2 * weights.opacity * (1 - opacity_[r]);
      for (std::size_t f = 0; f + 1 < kG; ++f) {
        feature_gradient[f + 1] = input_gradient[own * kG + f] * normaliser;
        opacity_gradient -= feature_gradient[f + 1] * color.input[own * kG + f];
      }
      ++own;
    }
    float behind = 0; // Σ over the samples behind of weight · its gradient
    for (std::size_t i = rays.first_sample[r + 1]; i-- > rays.first_sample[r];) {
      const float* g = geometry + i * kG;
      float* out = geometry_gradient + i * kG;
      float weight_gradient = opacity_gradient + scale * weights.depth * depth_term_[i];
      for (std::size_t f = 1; f < kG; ++f) {
        weight_gradient += feature_gradient[f] * g[f];
        out[f] = weight_[i] * feature_gradient[f];
      }
      out[0] = density_[i] * rays.samples[i].length * (transmittance_[i] * weight_gradient - behind);
      behind += weight_[i] * weight_gradient;
    }
  }
}

} // namespace kinora::fields
