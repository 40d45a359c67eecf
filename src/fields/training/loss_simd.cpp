#include "fields/training/loss.h"

#include <cmath>

#include "fields/model/field.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/training/loss_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>
// after highway.h
#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

ColorSums compare_colors(const RayBatch& rays, const float* outputs, const LossWeights& weights, float scale,
                         float* gradient) {
  const hn::CappedTag<float, 4> d;
  const auto one = hn::Set(d, 1.0F);
  const auto factor = hn::Set(d, scale * 2 * weights.color);
  constexpr float kMinLogit = 80; // beyond it the exponential is not defined, and the colour black
  HWY_ALIGN float errors[4] = {}; // by channel, like the next two
  HWY_ALIGN float targets[4] = {};
  HWY_ALIGN float squares[4] = {};
  for (const RayTarget& target : rays.targets) {
    if (!target.foreground) continue;
    HWY_ALIGN const float wanted[4] = {target.color[0], target.color[1], target.color[2], 0};
    HWY_ALIGN constexpr float kColors[4] = {1, 1, 1, 0};
    for (std::size_t v = 0; v < 4; v += hn::Lanes(d)) {
      const auto add = [&](float* sums, auto a, auto b)
                           HWY_ATTR { hn::Store(hn::MulAdd(a, b, hn::Load(d, sums + v)), d, sums + v); };
      const auto aim = hn::Load(d, wanted + v);
      const auto power = hn::Min(hn::Neg(hn::LoadU(d, outputs + v)), hn::Set(d, kMinLogit));
      const auto value = hn::Div(one, hn::Add(one, hn::Exp(d, power)));
      const auto difference = hn::Mul(hn::Sub(value, aim), hn::Load(d, kColors + v));
      add(errors, difference, difference);
      add(targets, aim, one);
      add(squares, aim, aim);
      const auto sigmoid_derivative = hn::Mul(value, hn::Sub(one, value));
      hn::StoreU(hn::Mul(hn::Mul(factor, difference), sigmoid_derivative), d, gradient + v);
    }
    outputs += FieldConfig::kColorOutputs;
    gradient += FieldConfig::kColorOutputs;
  }
  ColorSums sums;
  for (std::size_t c = 0; c < 3; ++c) {
    sums.squared_error += static_cast<double>(errors[c]);
    sums.squared_target += static_cast<double>(squares[c]);
    sums.target[c] = static_cast<double>(targets[c]);
  }
  return sums;
}

} // namespace kinora::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::fields {

HWY_EXPORT(compare_colors);

void ColorSums::add(const ColorSums& other) {
  squared_error += other.squared_error;
  squared_target += other.squared_target;
  for (std::size_t c = 0; c < 3; ++c) target[c] += other.target[c];
}

ColorSums compare_colors(const RayBatch& rays, const float* outputs, const LossWeights& weights, float scale,
                         std::vector<float>& gradient) {
  gradient.assign(rays.ray_count() * FieldConfig::kColorOutputs, 0.0F);
  return HWY_DYNAMIC_DISPATCH(compare_colors)(rays, outputs, weights, scale, gradient.data());
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
#endif
