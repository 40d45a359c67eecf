// Huber of robust_cost.h in lanes, for *_simd.cpp as vectors_simd.h; the same but for rounding.
#if defined(KINORA_CORE_ROBUST_COST_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_CORE_ROBUST_COST_SIMD_H
#undef KINORA_CORE_ROBUST_COST_SIMD_H
#else
#define KINORA_CORE_ROBUST_COST_SIMD_H
#endif

#include "core/vectors_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::vectors::HWY_NAMESPACE {

class HuberLanes {
public:
  HWY_INLINE explicit HuberLanes(float threshold) : threshold_(constant(threshold)) {}

  HWY_INLINE F cost(F r) const {
    const F size = hn::Abs(r);
    const F half = constant(0.5F);
    return hn::IfThenElse(hn::Le(size, threshold_), hn::Mul(half, hn::Mul(r, r)),
                          hn::Mul(threshold_, hn::NegMulAdd(half, threshold_, size)));
  }
  HWY_INLINE F weight(F r) const { return hn::Div(threshold_, hn::Max(hn::Abs(r), threshold_)); }

private:
  F threshold_;
};

} // namespace kinora::vectors::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
