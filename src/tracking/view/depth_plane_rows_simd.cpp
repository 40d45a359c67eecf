#include "tracking/view/depth_plane_rows.h"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tracking/view/depth_plane_rows_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>
// after highway.h
#include "core/sensor_noise_simd.h"
#include "core/vectors_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace vectors::HWY_NAMESPACE;

constexpr int kRadius = static_cast<int>(PlaneRows::kRadius);
constexpr float kMinNeighbours = 6;
constexpr float kMinSpread = 0.05F; // of the spread of pixels: less is a line, which leaves the slope across it open

/// Over the neighbours that lie within the gate, du and dv from the pixel, and inverse depth w.
struct Sums {
  F n, u, v, uu, uv, vv, w, wu, wv;
};

HWY_INLINE Sums sum_window(const PlaneRows& rows, std::size_t at, F z, F gate) {
  const Floats d;
  const F none = zero();
  Sums sums{none, none, none, none, none, none, none, none, none};
  for (int dv = -kRadius; dv <= kRadius; ++dv) {
    const int row = dv + kRadius;
    const float* depth = rows.depth[static_cast<std::size_t>(row)] + at;
    const float* inverse = rows.inverse[static_cast<std::size_t>(row)] + at;
    const F fv = constant(static_cast<float>(dv));
    F n = none, u = none, uu = none, w = none;
    for (int du = -kRadius; du <= kRadius; ++du) {
      const F fu = constant(static_cast<float>(du));
      const Mask within = hn::Lt(hn::Abs(hn::Sub(hn::LoadU(d, depth + du), z)), gate);
      const F one = hn::IfThenElseZero(within, constant(1));
      const F other = hn::IfThenElseZero(within, hn::LoadU(d, inverse + du));
      n = hn::Add(n, one);
      u = hn::MulAdd(one, fu, u);
      uu = hn::MulAdd(one, hn::Mul(fu, fu), uu);
      w = hn::Add(w, other);
      sums.wu = hn::MulAdd(other, fu, sums.wu);
    }
    sums.n = hn::Add(sums.n, n);
    sums.u = hn::Add(sums.u, u);
    sums.v = hn::MulAdd(n, fv, sums.v);
    sums.uu = hn::Add(sums.uu, uu);
    sums.uv = hn::MulAdd(u, fv, sums.uv);
    sums.vv = hn::MulAdd(n, hn::Mul(fv, fv), sums.vv);
    sums.w = hn::Add(sums.w, w);
    sums.wv = hn::MulAdd(w, fv, sums.wv);
  }
  return sums;
}

/// Inverse depth about each pixel: value + du · (u − pixel) + dv · (v − pixel).
struct InversePlane {
  F value, du, dv;
  Mask valid;
};

HWY_INLINE InversePlane solve(const Sums& s) {
  const F per_n = hn::Div(constant(1), s.n);
  const F mean_u = hn::Mul(s.u, per_n);
  const F mean_v = hn::Mul(s.v, per_n);
  const F mean_w = hn::Mul(s.w, per_n);
  const F uu = hn::NegMulAdd(s.u, mean_u, s.uu);
  const F uv = hn::NegMulAdd(s.u, mean_v, s.uv);
  const F vv = hn::NegMulAdd(s.v, mean_v, s.vv);
  const F wu = hn::NegMulAdd(s.u, mean_w, s.wu);
  const F wv = hn::NegMulAdd(s.v, mean_w, s.wv);
  const F determinant = hn::NegMulAdd(uv, uv, hn::Mul(uu, vv));
  const F spread = hn::Add(uu, vv);
  InversePlane plane;
  plane.du = hn::Div(hn::NegMulAdd(uv, wv, hn::Mul(vv, wu)), determinant);
  plane.dv = hn::Div(hn::NegMulAdd(uv, wu, hn::Mul(uu, wv)), determinant);
  plane.value = hn::NegMulAdd(plane.dv, mean_v, hn::NegMulAdd(plane.du, mean_u, mean_w));
  plane.valid = hn::And(hn::And(hn::Ge(s.n, constant(kMinNeighbours)), hn::Gt(plane.value, zero())),
                        hn::Ge(determinant, hn::Mul(constant(kMinSpread), hn::Mul(spread, spread))));
  return plane;
}

void fit_lanes(const PlaneRows& rows, std::size_t begin, std::size_t end, float* planes, float* weights) {
  const Floats d;
  const F none = zero();
  const F one = constant(1);
  const F max_gradient = constant(6 / rows.fx);
  const F y = constant(rows.y);
  const F reference = depth_sigma(one);
  HWY_ALIGN float plane[4 * kMaxLanes];
  HWY_ALIGN float weight[kMaxLanes];
  for (std::size_t u = begin; u < end; u += hn::Lanes(d)) {
    const std::size_t count = std::min(hn::Lanes(d), end - u);
    const F z = hn::LoadU(d, rows.depth[PlaneRows::kRadius] + u);
    const F gate =
        hn::IfThenElseZero(hn::Gt(z, none), hn::MulAdd(constant(4), depth_sigma(z), hn::Mul(max_gradient, z)));
    if (hn::AllFalse(d, hn::Gt(gate, none))) {
      std::fill_n(planes + 4 * u, 4 * count, 0.0F);
      std::fill_n(weights + u, count, 0.0F);
      continue;
    }
    const InversePlane fit = solve(sum_window(rows, u, z, gate));
    // Points of the plane satisfy a·X + b·Y + c·Z = 1.
    const F x = hn::Mul(hn::Sub(hn::Add(hn::Iota(d, 0), constant(static_cast<float>(u))), constant(rows.cx)),
                        constant(1 / rows.fx));
    const F a = hn::Mul(fit.du, constant(rows.fx));
    const F b = hn::Mul(fit.dv, constant(rows.fy));
    const F c = hn::NegMulAdd(a, x, hn::NegMulAdd(b, y, fit.value));
    const F scale = hn::Div(one, hn::Sqrt(hn::MulAdd(a, a, hn::MulAdd(b, b, hn::Mul(c, c)))));
    const auto stored = [&](F value) { return hn::IfThenElseZero(fit.valid, value); };
    const F back = hn::Neg(scale);
    hn::StoreInterleaved4(stored(hn::Mul(a, back)), stored(hn::Mul(b, back)), stored(hn::Mul(c, back)), stored(scale),
                          d, plane);
    const F cosine = hn::Div(hn::Mul(fit.value, scale), hn::Sqrt(hn::MulAdd(x, x, hn::MulAdd(y, y, one))));
    const F ratio = hn::Div(reference, depth_sigma(hn::Div(one, fit.value)));
    hn::Store(stored(hn::Mul(cosine, hn::Mul(ratio, ratio))), d, weight);
    std::memcpy(planes + 4 * u, plane, 4 * count * sizeof(float));
    std::memcpy(weights + u, weight, count * sizeof(float));
  }
}

} // namespace kinora::tracking::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::tracking {

HWY_EXPORT(fit_lanes);

void fit_row(const PlaneRows& rows, std::size_t begin, std::size_t end, float* planes, float* weights) {
  HWY_DYNAMIC_DISPATCH(fit_lanes)(rows, begin, end, planes, weights);
}

} // namespace kinora::tracking
#endif
