// Skinning in lanes, for *_simd.cpp after <hwy/foreach_target.h>: which nodes are nearest to points, what they weigh,
// and the dual-quaternion blend of their transforms, sixteen points at a time in single precision. Every kernel that
// moves points by nodes is made of these; DeformationGraph::influence and blend_motion are the same for one point in
// double precision, and tests/motion/skinning/skinning_agreement_test.cpp keeps all that use them equal.
// Source: Kavan et al., ACM TOG 27(4), 2008 (blending); Jiang et al., "Instant-NVR", CVPR 2023, sec. 4.1 (weights).
#if defined(KINORA_MOTION_SKINNING_SKINNING_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_MOTION_SKINNING_SKINNING_SIMD_H
#undef KINORA_MOTION_SKINNING_SKINNING_SIMD_H
#else
#define KINORA_MOTION_SKINNING_SKINNING_SIMD_H
#endif

#include <cstdint>

#include <hwy/highway.h>
// after highway.h
#include <hwy/contrib/math/math-inl.h>

#include "core/vectors_simd.h"
#include "motion/skinning/deformation_graph.h"
#include "motion/skinning/node_rows.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::skinning::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace vectors::HWY_NAMESPACE;
using motion::PositionRow;
using motion::TransformRow;

constexpr int kMaxNodes = motion::Influence::kMax; ///< that move a point
constexpr int kNearestNodes = kMaxNodes + 1;       ///< the last has no say, but its weight is taken from the others
/// What the nearest node weighs at least, where the heaviest possible weighs 1: where all nodes are equally far,
/// nothing is left of any weight, and the nearest moves the point alone. Above what rounding leaves of 1 − 1 (6e-8),
/// and too small to show beside any weight that does.
constexpr float kMinNearestWeight = 1e-6F;

// Nearest nodes

/// The nearest to each lane's point of nodes that are numbered from 0. The lowest bits of a squared distance give way
/// to the node's number, `kNone` (a power of two less one) standing for no node: so they are sorted with min and max
/// alone.
template <std::int32_t kNone = 0xFF> class NearestNodes {
public:
  /// `farthest`: squared, metres².
  HWY_INLINE explicit NearestNodes(float farthest) : none_(key(constant(farthest), kNone)) {
    for (F& kept : keys_) kept = none_;
  }

  HWY_INLINE void add(F squared_distance, std::int32_t number) { insert(key(squared_distance, number)); }
  HWY_INLINE void add_where(Mask is_node, F squared_distance, std::int32_t number) {
    insert(hn::IfThenElse(is_node, key(squared_distance, number), none_));
  }
  /// Of the k-th; kNone.
  HWY_INLINE I number(int k) const { return hn::And(hn::BitCast(Ints(), keys_[k]), hn::Set(Ints(), kNone)); }

private:
  HWY_INLINE static F key(F squared_distance, std::int32_t number) {
    const Ints di;
    const I distance = hn::AndNot(hn::Set(di, kNone), hn::BitCast(di, squared_distance));
    return hn::BitCast(Floats(), hn::Or(distance, hn::Set(di, number)));
  }
  HWY_INLINE void insert(F candidate) {
    for (F& kept : keys_) {
      const F nearer = hn::Min(kept, candidate);
      candidate = hn::Max(kept, candidate);
      kept = nearer;
    }
  }

  F none_;
  F keys_[kNearestNodes];
};

HWY_INLINE Vec3 gather_positions(const PositionRow* positions, I node) {
  return gather4(positions->data(), hn::ShiftLeft<2>(node)).v;
}

// Weights

/// As DeformationGraph::influence has them, but not yet divided by their sum.
struct NodeWeights {
  F falloffs[kNearestNodes]; ///< exp((d₀² − dₖ²) / r²)
  F values[kMaxNodes];       ///< less that of the last: a little below zero where that is the nearer by a little
};

/// `squared`: distances, nearest first; where there is no node, the square of the radius of influence, from where on
/// nothing has weight.
HWY_INLINE NodeWeights skinning_weights_of(const F (&squared)[kNearestNodes], float inverse_squared_radius) {
  NodeWeights weights;
  for (int k = 0; k < kNearestNodes; ++k) {
    weights.falloffs[k] = hn::Exp(Floats(), hn::Mul(hn::Sub(squared[0], squared[k]), constant(inverse_squared_radius)));
  }
  for (int k = 0; k < kMaxNodes; ++k) weights.values[k] = hn::Sub(weights.falloffs[k], weights.falloffs[kMaxNodes]);
  weights.values[0] = hn::Max(weights.values[0], constant(kMinNearestWeight));
  return weights;
}

// Transforms

/// Dual quaternions, real + ε·dual.
struct DualQuat {
  Quat real, dual;
};

HWY_INLINE DualQuat no_transform() {
  const Vec3 nothing{zero(), zero(), zero()};
  return {{nothing, zero()}, {nothing, zero()}};
}
HWY_INLINE DualQuat mul(F s, const DualQuat& q) { return {mul(s, q.real), mul(s, q.dual)}; }
/// s · a + b
HWY_INLINE DualQuat mul_add(F s, const DualQuat& a, const DualQuat& b) {
  return {mul_add(s, a.real, b.real), mul_add(s, a.dual, b.dual)};
}

/// Of the nodes node_of(lane).
template <class NodeOf> HWY_INLINE DualQuat load_transforms(const TransformRow* rows, const NodeOf& node_of) {
  return {load_rows([&](std::size_t lane) { return rows[node_of(lane)].real.data(); }),
          load_rows([&](std::size_t lane) { return rows[node_of(lane)].dual.data(); })};
}
HWY_INLINE DualQuat gather_transforms(const TransformRow* rows, I node) {
  HWY_ALIGN std::int32_t nodes[hn::MaxLanes(Ints())];
  hn::Store(node, Ints(), nodes);
  return load_transforms(rows, [&](std::size_t lane) { return nodes[lane]; });
}

/// q and −q are the same rotation: the weight with the sign that brings it into the hemisphere of the heaviest.
HWY_INLINE F in_hemisphere(F weight, const Quat& real, const Quat& heaviest) {
  return hn::IfThenElse(hn::Lt(dot(real, heaviest), zero()), hn::Neg(weight), weight);
}

/// Σ weight_of(k) · transform_of(k), k = 0 of the heaviest node; both are asked for no more than some lane has weights.
template <class WeightOf, class TransformOf>
HWY_INLINE DualQuat weighted_sum(const WeightOf& weight_of, const TransformOf& transform_of) {
  DualQuat sum = no_transform();
  Quat heaviest;
  for (std::size_t k = 0; k < kMaxNodes; ++k) {
    const F weight = weight_of(k);
    if (k > 0 && hn::AllTrue(Floats(), hn::Eq(weight, zero()))) break;
    const DualQuat transform = transform_of(k);
    if (k == 0) heaviest = transform.real;
    sum = mul_add(in_hemisphere(weight, transform.real, heaviest), transform, sum);
  }
  return sum;
}

/// `by`: of unit length.
HWY_INLINE Vec3 rotated(const Quat& by, const Vec3& v) {
  const Vec3 half = cross(by.v, v);
  const Vec3 twice = add(half, half);
  return add(mul_add(by.w, twice, v), cross(by.v, twice));
}
HWY_INLINE Quat inverse(const Quat& unit) { return {unit.v, hn::Neg(unit.w)}; }

/// Of the translation of r + εd, for which r is of unit length.
HWY_INLINE Vec3 half_translation(const Quat& r, const Quat& d) {
  return add(sub(mul(r.w, d.v), mul(d.w, r.v)), cross(r.v, d.v));
}

/// By how much r + εd moves a point, without the factor 2 / |r|²: Σ of translation + rotation − identity. `rotated`:
/// what its derivative needs.
HWY_INLINE Vec3 displacement(const Quat& r, const Quat& d, const Vec3& at, Vec3& rotated) {
  rotated = mul_add(r.w, at, cross(r.v, at));
  const Vec3 inner = add(rotated, d.v);
  return add(cross(r.v, inner), sub(mul(r.w, d.v), mul(d.w, r.v)));
}

/// The sum of weighed transforms in the hemisphere of the heaviest, and what it does. It is not normalised, since that
/// does not depend on its length, and does not vanish (core/dual_quaternion.h); where all weights are zero nothing
/// moves a point, and all of this is NaN.
struct Blend {
  Quat real, dual;
  F twice_inverse_norm; ///< 2 / |real|²

  HWY_INLINE Blend() = default;
  HWY_INLINE explicit Blend(const DualQuat& sum) : real(sum.real), dual(sum.dual) {
    const F norm = dot(real, real);
    twice_inverse_norm = hn::IfThenElse(hn::Gt(norm, zero()), hn::Div(constant(2), norm), hn::NaN(Floats()));
  }
  /// Of transforms as they are stored.
  HWY_INLINE static Blend of_unit(const DualQuat& transform) {
    Blend blend;
    blend.real = transform.real;
    blend.dual = transform.dual;
    blend.twice_inverse_norm = constant(2);
    return blend;
  }

  HWY_INLINE Vec3 apply(const Vec3& at) const {
    Vec3 rotated;
    return mul_add(twice_inverse_norm, displacement(real, dual, at, rotated), at);
  }
  HWY_INLINE Vec3 rotate(const Vec3& v) const {
    const Vec3 rotated = mul_add(real.w, v, cross(real.v, v));
    return mul_add(twice_inverse_norm, cross(real.v, rotated), v);
  }
  HWY_INLINE Vec3 inverse_rotate(const Vec3& v) const {
    const Vec3 rotated = sub(mul(real.w, v), cross(real.v, v));
    return sub(v, mul(twice_inverse_norm, cross(real.v, rotated)));
  }
  HWY_INLINE Vec3 inverse_apply(const Vec3& at) const {
    return inverse_rotate(sub(at, mul(twice_inverse_norm, half_translation(real, dual))));
  }
  /// A unit quaternion.
  HWY_INLINE Quat rotation() const { return mul(hn::Sqrt(hn::Mul(constant(0.5F), twice_inverse_norm)), real); }
};

/// The same sum normalised, with what its derivative by the nodes needs: a dual number, as BlendedMotion has it.
struct NormalisedBlend {
  Quat real, dual; ///< of unit length, and normal to that
  F inverse_norm;  ///< of the sum's real part
  F dual_norm;

  HWY_INLINE explicit NormalisedBlend(const DualQuat& sum)
      : inverse_norm(hn::Div(constant(1), hn::Sqrt(dot(sum.real, sum.real)))) {
    real = mul(inverse_norm, sum.real);
    dual_norm = dot(real, sum.dual);
    dual = mul(inverse_norm, mul_add(hn::Neg(dual_norm), real, sum.dual));
  }

  HWY_INLINE Vec3 apply(const Vec3& at) const {
    return mul_add(constant(2), half_translation(real, dual), rotated(real, at));
  }
  HWY_INLINE Vec3 rotate(const Vec3& v) const { return rotated(real, v); }
};

} // namespace kinora::skinning::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
