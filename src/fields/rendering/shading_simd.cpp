#include "fields/rendering/shading.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/rendering/shading_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>
// after highway.h
#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void to_colors(const float* outputs, std::size_t n, float* colors) {
  const hn::CappedTag<float, 4> d;
  const auto one = hn::Set(d, 1.0F);
  const auto largest = hn::Set(d, 80.0F); // beyond it the exponential is not defined, and the colour black
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t v = 0; v < 4; v += hn::Lanes(d)) {
      const auto power = hn::Min(hn::Neg(hn::LoadU(d, outputs + i * FieldConfig::kColorOutputs + v)), largest);
      hn::StoreU(hn::Div(one, hn::Add(one, hn::Exp(d, power))), d, colors + 4 * i + v);
    }
  }
}

} // namespace kinora::fields::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::fields::kernels {

HWY_EXPORT(to_colors);

void to_colors(const float* outputs, std::size_t n, float* colors) {
  HWY_DYNAMIC_DISPATCH(to_colors)(outputs, n, colors);
}

} // namespace kinora::fields::kernels
#endif
