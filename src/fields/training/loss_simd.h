// The colours' term of the loss, in vectors: compositing_simd.cpp compiles it for every instruction set.
#if defined(KINORA_FIELDS_TRAINING_LOSS_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_FIELDS_TRAINING_LOSS_SIMD_H
#undef KINORA_FIELDS_TRAINING_LOSS_SIMD_H
#else
#define KINORA_FIELDS_TRAINING_LOSS_SIMD_H
#endif

#include "fields/model/field.h"
#include "fields/training/loss.h"

#include <hwy/highway.h>
// after highway.h
#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

inline ColorSums compare_colors(const RayBatch& rays, const float* outputs, const LossWeights& weights, float scale,
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

#endif
