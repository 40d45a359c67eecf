// Dual-quaternion blending of a layer's points in lanes, for *_simd.cpp after <hwy/foreach_target.h>; the same as
// blend_motion() but for rounding.
#if defined(KINORA_TRACKING_POINT_BLEND_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_TRACKING_POINT_BLEND_SIMD_H
#undef KINORA_TRACKING_POINT_BLEND_SIMD_H
#else
#define KINORA_TRACKING_POINT_BLEND_SIMD_H
#endif

#include "core/vectors_simd.h"
#include "tracking/layer_pose.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace vectors::HWY_NAMESPACE;

/// Which of `count` items each lane takes: beyond the last, the last again.
HWY_INLINE std::size_t item_of(std::size_t lane, std::size_t count) { return lane < count ? lane : count - 1; }

HWY_INLINE Quat mul(F s, const Quat& q) { return {mul(s, q.v), hn::Mul(s, q.w)}; }

/// `by`: of unit length.
HWY_INLINE Vec3 rotated(const Quat& by, const Vec3& v) {
  const Vec3 half = cross(by.v, v);
  const Vec3 twice = add(half, half);
  return add(mul_add(by.w, twice, v), cross(by.v, twice));
}

/// The transforms of the nodes that carry each lane's point, weighed, and their normalised sum.
struct Blend {
  Quat real[Influence::kMost], dual[Influence::kMost]; ///< times the weight, in the hemisphere of the heaviest
  Quat sum_real, sum_dual;                             ///< of unit length, and normal to that
  F inverse_norm;                                      ///< of the sum before it was normalised
  F dual_norm;                                         ///< likewise
  Mask regular;                                        ///< no: rotations cancel, the heaviest moves the point alone
};

/// `points`: at least `count` > 0 of them.
HWY_INLINE Blend blend(const SkinnedPoint* points, std::size_t count, const NodeRow* nodes) {
  Blend b;
  const Quat weights = load_rows([&](std::size_t lane) { return points[item_of(lane, count)].weights.data(); });
  const F of_node[Influence::kMost] = {weights.v.x, weights.v.y, weights.v.z, weights.w};
  const auto load = [&](std::size_t k, const std::array<float, 4> NodeRow::*row) {
    return load_rows([&](std::size_t lane) { return (nodes[points[item_of(lane, count)].nodes[k]].*row).data(); });
  };
  const Quat heaviest = load(0, &NodeRow::real);
  const Quat heaviest_dual = load(0, &NodeRow::dual);
  for (std::size_t k = 0; k < Influence::kMost; ++k) {
    const Quat real = k == 0 ? heaviest : load(k, &NodeRow::real);
    const Quat dual = k == 0 ? heaviest_dual : load(k, &NodeRow::dual);
    const F weight = hn::IfThenElse(hn::Lt(dot(real, heaviest), zero()), hn::Neg(of_node[k]), of_node[k]);
    b.real[k] = mul(weight, real);
    b.dual[k] = mul(weight, dual);
    b.sum_real = k == 0 ? b.real[0] : mul_add(weight, real, b.sum_real);
    b.sum_dual = k == 0 ? b.dual[0] : mul_add(weight, dual, b.sum_dual);
  }
  const F norm = hn::Sqrt(dot(b.sum_real, b.sum_real));
  b.regular = hn::Gt(norm, constant(1e-6F));
  b.inverse_norm = hn::Div(constant(1), hn::IfThenElse(b.regular, norm, constant(1)));
  const auto pick = [&](const Quat& blended, const Quat& alone) {
    return Quat{choose(b.regular, blended.v, alone.v), hn::IfThenElse(b.regular, blended.w, alone.w)};
  };
  const Quat unit = mul(b.inverse_norm, b.sum_real);
  b.dual_norm = dot(unit, b.sum_dual);
  const Quat normal = mul(b.inverse_norm, mul_add(hn::Neg(b.dual_norm), unit, b.sum_dual));
  b.sum_real = pick(unit, heaviest);
  b.sum_dual = pick(normal, heaviest_dual);
  return b;
}

} // namespace kinora::tracking::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
