#include "fields/network/volume_density.h"

#include <algorithm>

#include "fields/model/field.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/network/volume_density_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>
// after highway.h
#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kBlock = 16;

void densities(const float* geometry, const float* lengths, std::size_t n, float* density, float* transmittance) {
  const hn::CappedTag<float, kBlock> d;
  HWY_ALIGN float raw[kBlock] = {};
  HWY_ALIGN float length[kBlock] = {};
  HWY_ALIGN float sigma[kBlock];
  HWY_ALIGN float block_transmittance[kBlock];
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t count = std::min(kBlock, n - begin);
    for (std::size_t i = 0; i < count; ++i) {
      raw[i] = geometry[(begin + i) * FieldConfig::kGeometry];
      length[i] = lengths[begin + i];
    }
    for (std::size_t i = 0; i < kBlock; i += hn::Lanes(d)) {
      const auto s = hn::Exp(d, hn::Min(hn::Load(d, raw + i), hn::Set(d, kMaxRawDensity)));
      hn::Store(s, d, sigma + i);
      hn::Store(hn::Exp(d, hn::Neg(hn::Mul(s, hn::Load(d, length + i)))), d, block_transmittance + i);
    }
    for (std::size_t i = 0; i < count; ++i) {
      density[begin + i] = sigma[i];
      transmittance[begin + i] = block_transmittance[i];
    }
  }
}

} // namespace kinora::fields::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::fields::kernels {

HWY_EXPORT(densities);

void densities(const float* geometry, const float* lengths, std::size_t n, float* density, float* transmittance) {
  HWY_DYNAMIC_DISPATCH(densities)(geometry, lengths, n, density, transmittance);
}

} // namespace kinora::fields::kernels
#endif
