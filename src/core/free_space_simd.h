// free_space.h in lanes, for *_simd.cpp as vectors_simd.h; the same but for rounding.
#if defined(KINORA_CORE_FREE_SPACE_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_CORE_FREE_SPACE_SIMD_H
#undef KINORA_CORE_FREE_SPACE_SIMD_H
#else
#define KINORA_CORE_FREE_SPACE_SIMD_H
#endif

#include "core/free_space.h"
#include "core/sensor_noise_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::vectors::HWY_NAMESPACE {

/// DepthMargin::at
HWY_INLINE F margin_at(const DepthMargin& margin, F z) {
  return hn::Max(constant(static_cast<float>(margin.metres)),
                 hn::Mul(constant(static_cast<float>(margin.sigmas)), depth_sigma(z)));
}

HWY_INLINE Mask is_occluded(F z, F measured, const DepthMargin& margin) {
  return hn::And(hn::Gt(measured, zero()), hn::Lt(measured, hn::Sub(z, margin_at(margin, z))));
}

} // namespace kinora::vectors::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
