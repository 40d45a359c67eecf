#include "tracking/carried_lanes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tracking/carried_lanes_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>
// after highway.h
#include <hwy/contrib/math/math-inl.h>

#include "core/vectors_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace vectors::HWY_NAMESPACE;

constexpr std::size_t kPoints = PointLanes::kPoints;
constexpr int kMost = Influence::kMost;
constexpr int kWeighed = kMost + 1; // the last has no say, but its weight is taken from the others
constexpr std::int32_t kSlotBits = 0xFF;

HWY_INLINE Vec3 load(const PointLanes& points, std::size_t first) {
  const Floats d;
  return {hn::LoadU(d, points.along[0].data() + first), hn::LoadU(d, points.along[1].data() + first),
          hn::LoadU(d, points.along[2].data() + first)};
}

HWY_INLINE void store(const Vec3& v, std::size_t first, PointLanes& points) {
  const Floats d;
  hn::StoreU(v.x, d, points.along[0].data() + first);
  hn::StoreU(v.y, d, points.along[1].data() + first);
  hn::StoreU(v.z, d, points.along[2].data() + first);
}

void weigh_lanes(const NodesInQuestion& nodes, const PointLanes& points, InfluenceLanes& influences) {
  const Floats df;
  const Ints di;
  const I slots = hn::Set(di, kSlotBits);
  const F reach = constant(nodes.influence_radius * nodes.influence_radius);
  const F scale = constant(1 / (nodes.weight_radius * nodes.weight_radius));
  const F none = hn::BitCast(df, hn::Or(hn::BitCast(di, reach), slots));
  for (std::size_t first = 0; first < kPoints; first += hn::Lanes(df)) {
    const Vec3 at = load(points, first);
    // The lowest bits of a squared distance say which node it is: the nearest are found with min and max alone.
    F nearest[kWeighed] = {none, none, none, none, none};
    for (std::size_t slot = 0; slot < nodes.nodes.size(); ++slot) {
      const float* position = nodes.positions + 4 * static_cast<std::ptrdiff_t>(nodes.nodes[slot]);
      const Vec3 offset = sub(at, {constant(position[0]), constant(position[1]), constant(position[2])});
      const I number = hn::Set(di, static_cast<std::int32_t>(slot));
      F distance = hn::BitCast(df, hn::Or(hn::AndNot(slots, hn::BitCast(di, dot(offset, offset))), number));
      for (F& kept : nearest) {
        const F nearer = hn::Min(kept, distance);
        distance = hn::Max(kept, distance);
        kept = nearer;
      }
    }
    I node[kWeighed];
    F squared[kWeighed];
    Mask present[kWeighed];
    for (int k = 0; k < kWeighed; ++k) {
      const I slot = hn::And(hn::BitCast(di, nearest[k]), slots);
      const auto is_node = hn::Ne(slot, slots);
      present[k] = hn::RebindMask(df, is_node);
      if (hn::AllFalse(di, is_node)) {
        node[k] = hn::Zero(di);
        squared[k] = reach;
        continue;
      }
      node[k] = hn::IfThenElseZero(is_node, hn::GatherIndex(di, nodes.nodes.data(), hn::IfThenElseZero(is_node, slot)));
      const Vec3 offset = sub(at, gather4(nodes.positions, hn::ShiftLeft<2>(node[k])).v);
      squared[k] = hn::IfThenElse(present[k], dot(offset, offset), reach);
    }
    const auto weight = [&](int k) { return hn::Exp(df, hn::Mul(hn::Sub(squared[0], squared[k]), scale)); };
    const F without = weight(kMost);
    F weights[kMost];
    F total = zero();
    for (int k = 0; k < kMost; ++k) {
      weights[k] = hn::IfThenElseZero(present[k], hn::Max(hn::Sub(weight(k), without), zero()));
      total = hn::Add(total, weights[k]);
    }
    // All nodes equally far: the nearest moves the point alone.
    const Mask is_weighed = hn::Gt(total, zero());
    weights[0] = hn::IfThenElse(is_weighed, weights[0], hn::IfThenElseZero(present[0], constant(1)));
    const F share = hn::Div(constant(1), hn::IfThenElse(is_weighed, total, constant(1)));
    for (int k = 0; k < kMost; ++k) {
      hn::StoreU(hn::Mul(weights[k], share), df, influences.weights[static_cast<std::size_t>(k)].data() + first);
      hn::StoreU(node[k], di, influences.nodes[static_cast<std::size_t>(k)].data() + first);
    }
  }
}

/// The blend of the nodes' transforms at each point: not normalised, since what it does does not depend on its scale.
struct LaneBlend {
  Quat real, dual;
  F twice_inverse_norm; ///< 2 / |real|²; NaN where nothing moves the point
};

HWY_INLINE LaneBlend blend_lanes(const float* transforms, const InfluenceLanes& influences, std::size_t first) {
  const Floats df;
  const Ints di;
  LaneBlend blend;
  Quat heaviest_real;
  F heaviest = zero();
  for (std::size_t k = 0; k < Influence::kMost; ++k) {
    F weight = hn::LoadU(df, influences.weights[k].data() + first);
    if (k > 0 && hn::AllTrue(df, hn::Eq(weight, zero()))) break;
    const I node = hn::ShiftLeft<3>(hn::LoadU(di, influences.nodes[k].data() + first));
    const Quat real = gather4(transforms, node);
    const Quat dual = gather4(transforms + 4, node);
    if (k == 0) {
      heaviest = weight;
      heaviest_real = real;
      blend.real = {mul(weight, real.v), hn::Mul(weight, real.w)};
      blend.dual = {mul(weight, dual.v), hn::Mul(weight, dual.w)};
      continue;
    }
    weight = hn::IfThenElse(hn::Lt(dot(real, heaviest_real), zero()), hn::Neg(weight), weight);
    blend.real = mul_add(weight, real, blend.real);
    blend.dual = mul_add(weight, dual, blend.dual);
  }
  // In one hemisphere, and with the heaviest of four among them, rotations do not cancel.
  const F norm = dot(blend.real, blend.real);
  blend.twice_inverse_norm = hn::IfThenElse(hn::Gt(heaviest, zero()), hn::Div(constant(2), norm), hn::NaN(df));
  return blend;
}

void carry_lanes(const float* transforms, const InfluenceLanes& influences, const PointLanes& points,
                 PointLanes& places, const PointLanes* vectors, PointLanes* turned) {
  for (std::size_t first = 0; first < kPoints; first += hn::Lanes(Floats())) {
    const LaneBlend blend = blend_lanes(transforms, influences, first);
    const Vec3 at = load(points, first);
    Vec3 half_turned;
    store(mul_add(blend.twice_inverse_norm, displacement(blend.real, blend.dual, at, half_turned), at), first, places);
    if (vectors == nullptr) continue;
    const Vec3 v = load(*vectors, first);
    const Vec3 inner = mul_add(blend.real.w, v, cross(blend.real.v, v));
    store(mul_add(blend.twice_inverse_norm, cross(blend.real.v, inner), v), first, *turned);
  }
}

} // namespace kinora::tracking::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::tracking {

HWY_EXPORT(weigh_lanes);
HWY_EXPORT(carry_lanes);

void InfluenceLanes::set(std::size_t point, const Influence& influence) {
  for (std::size_t k = 0; k < Influence::kMost; ++k) {
    const bool is_node = k < static_cast<std::size_t>(influence.count);
    nodes[k][point] = is_node ? influence.nodes[k] : 0;
    weights[k][point] = is_node ? static_cast<float>(influence.weights[k]) : 0.0F;
  }
}

Influence InfluenceLanes::at(std::size_t point) const {
  Influence influence;
  double total = 0;
  for (std::size_t k = 0; k < Influence::kMost && weights[k][point] > 0; ++k, ++influence.count) {
    influence.nodes[k] = nodes[k][point];
    total += influence.weights[k] = static_cast<double>(weights[k][point]);
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) influence.weights[k] /= total;
  return influence;
}

void weigh_nodes(const NodesInQuestion& nodes, const PointLanes& points, InfluenceLanes& influences) {
  HWY_DYNAMIC_DISPATCH(weigh_lanes)(nodes, points, influences);
}

std::vector<float> packed_transforms(const NodeStates& states) {
  std::vector<float> packed;
  packed.reserve(8 * states.size());
  for (const DualQuaternion& transform : states.transforms) {
    for (const Eigen::Quaterniond* part : {&transform.real, &transform.dual}) {
      for (int i = 0; i < 4; ++i) packed.push_back(static_cast<float>(part->coeffs()[i])); // x y z w
    }
  }
  return packed;
}

void carry_points(std::span<const float> transforms, const InfluenceLanes& influences, const PointLanes& points,
                  PointLanes& places) {
  HWY_DYNAMIC_DISPATCH(carry_lanes)(transforms.data(), influences, points, places, nullptr, nullptr);
}

void carry_points(std::span<const float> transforms, const InfluenceLanes& influences, const PointLanes& points,
                  PointLanes& places, const PointLanes& vectors, PointLanes& turned) {
  HWY_DYNAMIC_DISPATCH(carry_lanes)(transforms.data(), influences, points, places, &vectors, &turned);
}

} // namespace kinora::tracking
#endif
