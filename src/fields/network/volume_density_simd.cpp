#include "fields/network/volume_density.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fields/model/field.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/network/volume_density_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>
// after highway.h
#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kG = FieldConfig::kGeometry;
constexpr std::size_t kBlock = 16;
using Tag = hn::CappedTag<float, kBlock>;
using Vector = hn::Vec<Tag>;

void densities(const float* geometry, const float* lengths, std::size_t n, float* density, float* transmittance) {
  const Tag d;
  HWY_ALIGN float raw[kBlock] = {};
  HWY_ALIGN float length[kBlock] = {};
  HWY_ALIGN float sigma[kBlock];
  HWY_ALIGN float block_transmittance[kBlock];
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t count = std::min(kBlock, n - begin);
    for (std::size_t i = 0; i < count; ++i) {
      raw[i] = geometry[(begin + i) * kG];
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

/// ½ exp(−|u|): the share of the Laplace distribution beyond u.
HWY_INLINE Vector tail(Vector u) {
  const Tag d;
  return hn::Mul(hn::Set(d, 0.5F), hn::Exp(d, hn::Neg(hn::Abs(u))));
}

void to_log_densities(float sharpness, std::size_t n, float* geometry, float* distances) {
  const Tag d;
  const auto rate = hn::Set(d, std::exp(sharpness));
  HWY_ALIGN float block[kBlock] = {};
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t count = std::min(kBlock, n - begin);
    float* rows = geometry + begin * kG;
    for (std::size_t i = 0; i < count; ++i) block[i] = distances[begin + i] = rows[i * kG];
    for (std::size_t i = 0; i < kBlock; i += hn::Lanes(d)) {
      const auto u = hn::Mul(hn::Load(d, block + i), rate);
      const auto outside = hn::Sub(hn::Set(d, -std::numbers::ln2_v<float>), u);
      const auto inside = hn::Log1p(d, hn::Neg(tail(u)));
      const auto relative = hn::IfThenElse(hn::Ge(u, hn::Zero(d)), outside, inside);
      hn::Store(hn::Add(hn::Set(d, sharpness), relative), d, block + i);
    }
    for (std::size_t i = 0; i < count; ++i) rows[i * kG] = block[i];
  }
}

/// gradients: of the logarithms of density, then of the distances; returns that of the sharpness.
double through_density(const float* distances, float sharpness, std::size_t n, float* gradients) {
  const Tag d;
  const auto rate = hn::Set(d, std::exp(sharpness));
  const auto one = hn::Set(d, 1.0F);
  HWY_ALIGN float u_block[kBlock] = {};
  HWY_ALIGN float block[kBlock] = {};
  double by_sharpness = 0;
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t count = std::min(kBlock, n - begin);
    float* rows = gradients + begin * kG;
    std::fill_n(block, kBlock, 0.0F);
    std::copy_n(distances + begin, count, u_block);
    for (std::size_t i = 0; i < count; ++i) block[i] = rows[i * kG];
    auto sum = hn::Zero(d);
    for (std::size_t i = 0; i < kBlock; i += hn::Lanes(d)) {
      const auto u = hn::Mul(hn::Load(d, u_block + i), rate);
      const auto gradient = hn::Load(d, block + i);
      const auto h = tail(u);
      const auto fall = hn::IfThenElse(hn::Ge(u, hn::Zero(d)), one, hn::Div(h, hn::Sub(one, h)));
      sum = hn::MulAdd(gradient, hn::NegMulAdd(u, fall, one), sum);
      hn::Store(hn::Neg(hn::Mul(hn::Mul(gradient, rate), fall)), d, block + i);
    }
    by_sharpness += static_cast<double>(hn::GetLane(hn::SumOfLanes(d, sum)));
    for (std::size_t i = 0; i < count; ++i) rows[i * kG] = block[i];
  }
  return by_sharpness;
}

} // namespace kinora::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::fields {

HWY_EXPORT(densities);
HWY_EXPORT(to_log_densities);
HWY_EXPORT(through_density);

void kernels::densities(const float* geometry, const float* lengths, std::size_t n, float* density,
                        float* transmittance) {
  HWY_DYNAMIC_DISPATCH(densities)(geometry, lengths, n, density, transmittance);
}

void to_log_densities(float sharpness, std::size_t n, float* geometry, float* distances) {
  HWY_DYNAMIC_DISPATCH(to_log_densities)(sharpness, n, geometry, distances);
}

double through_density(std::span<const float> distances, float sharpness, float* geometry_gradient) {
  return HWY_DYNAMIC_DISPATCH(through_density)(distances.data(), sharpness, distances.size(), geometry_gradient);
}

} // namespace kinora::fields
#endif
