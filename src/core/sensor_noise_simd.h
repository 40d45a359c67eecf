// SensorNoise of the sensor itself in lanes, for *_simd.cpp as vectors_simd.h; the same but for rounding.
#if defined(KINORA_CORE_SENSOR_NOISE_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_CORE_SENSOR_NOISE_SIMD_H
#undef KINORA_CORE_SENSOR_NOISE_SIMD_H
#else
#define KINORA_CORE_SENSOR_NOISE_SIMD_H
#endif

#include "core/sensor_noise.h"
#include "core/vectors_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::vectors::HWY_NAMESPACE {

/// SensorNoise::sigma
HWY_INLINE F depth_sigma(F z) {
  const F beyond = hn::Sub(z, constant(static_cast<float>(SensorNoise::kNearest)));
  return hn::MulAdd(hn::Mul(constant(static_cast<float>(SensorNoise::kGrowth)), beyond), beyond,
                    constant(static_cast<float>(SensorNoise::kMinSigma)));
}

/// SensorNoise::sigma_across
HWY_INLINE F depth_sigma_across(F z, F cosine) {
  return hn::Mul(depth_sigma(z), hn::Max(constant(static_cast<float>(SensorNoise::kMinCosine)), cosine));
}

} // namespace kinora::vectors::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
