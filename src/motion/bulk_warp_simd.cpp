#include "motion/bulk_warp_kernels.h"

#include "motion/skinning/node_candidates.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "motion/bulk_warp_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

#include "motion/skinning/skinning_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::motion::kernels::HWY_NAMESPACE {
using namespace skinning::HWY_NAMESPACE;

/// The nodes that move each lane's point, nearest first, and the first that does not.
struct Nodes {
  Vec3 position[kNearestNodes];
  Mask present[kNearestNodes];
  DualQuat transform[kMaxNodes]; ///< in the hemisphere of the nearest
};

HWY_NOINLINE void find_nodes(const NodeMotion& motion, const Vec3& at, Nodes& nodes) {
  const Floats df;
  const Ints di;
  const InfluenceTable::Cells& cells = *motion.cells;
  const F scale = constant(cells.per_metre);
  const auto along = [&](F coordinate, std::size_t axis, Mask& inside) {
    const F cell = hn::Mul(hn::Sub(coordinate, constant(cells.low[axis])), scale);
    inside =
        hn::And(inside, hn::And(hn::Ge(cell, zero()), hn::Lt(cell, constant(static_cast<float>(cells.count[axis])))));
    return cell;
  };
  Mask inside = hn::Eq(at.x, at.x);
  const F x = along(at.x, 0, inside);
  const F y = along(at.y, 1, inside);
  const F z = along(at.z, 2, inside);
  const auto whole = [&](F cell) { return hn::ConvertTo(di, hn::IfThenElseZero(inside, cell)); };
  const I row = hn::Add(hn::Mul(whole(z), hn::Set(di, cells.count[1])), whole(y));
  const I cell = hn::Add(hn::Mul(row, hn::Set(di, cells.count[0])), whole(x));
  const I first = hn::GatherIndex(di, cells.begin.data(), cell);
  const I end = hn::GatherIndex(di, cells.begin.data() + 1, cell);
  const I count = hn::IfThenElseZero(hn::RebindMask(di, inside), hn::Sub(end, first));
  const std::int32_t most = hn::GetLane(hn::MaxOfLanes(di, count));

  constexpr std::int32_t kNone = NodeCandidates::kMax;
  NearestNodes<kNone> nearest(cells.squared_influence_radius);
  const std::int32_t* candidates = cells.candidates.data();
  for (std::int32_t slot = 0; slot < most; ++slot) {
    const auto present = hn::Lt(hn::Set(di, slot), count);
    const I candidate = hn::IfThenElseZero(present, hn::Add(first, hn::Set(di, slot)));
    HWY_ALIGN std::int32_t positions[hn::MaxLanes(di)];
    hn::Store(candidate, di, positions);
    const Vec3 position =
        load_rows([&](std::size_t lane) { return cells.positions[candidates[positions[lane]]].data(); }).v;
    const Vec3 offset = sub(at, position);
    nearest.add_where(hn::RebindMask(df, present), dot(offset, offset), slot);
  }
  for (int k = 0; k < kNearestNodes; ++k) {
    const I slot = nearest.number(k);
    const auto present = hn::Ne(slot, hn::Set(di, kNone));
    nodes.present[k] = hn::RebindMask(df, present);
    const I node = hn::GatherIndex(di, candidates, hn::IfThenElseZero(present, hn::Add(first, slot)));
    nodes.position[k] = gather_positions(cells.positions.data(), node);
    if (k == kMaxNodes) break;
    const DualQuat transform = gather_transforms(motion.transforms, node);
    const Quat& heaviest = k == 0 ? transform.real : nodes.transform[0].real;
    nodes.transform[k] = mul(in_hemisphere(constant(1), transform.real, heaviest), transform);
  }
}

/// The blend of the nodes' transforms at a point, and how it changes with the point. The nodes are not looked for
/// again wherever it goes: weights may be below zero by then, so that Newton's steps see a smooth function.
struct BlendAt {
  Blend blend;
  Vec3 weight_gradients[kMaxNodes]; ///< by the point
};

HWY_INLINE BlendAt blend_at(const NodeMotion& motion, const Nodes& nodes, const Vec3& at) {
  const float inverse = motion.cells->inverse_squared_weight_radius;
  const F reach = constant(motion.cells->squared_influence_radius);
  Vec3 offsets[kNearestNodes];
  F squared[kNearestNodes];
  for (int k = 0; k < kNearestNodes; ++k) {
    offsets[k] = sub(at, nodes.position[k]);
    squared[k] = hn::IfThenElse(nodes.present[k], dot(offsets[k], offsets[k]), reach);
  }
  const NodeWeights weights = skinning_weights_of(squared, inverse);
  const auto derivative = [&](int k) HWY_ATTR {
    const F per_offset = hn::Mul(hn::Mul(constant(-2), constant(inverse)), weights.falloffs[k]);
    return mul(hn::IfThenElseZero(nodes.present[k], per_offset), offsets[k]);
  };
  BlendAt result;
  DualQuat sum = no_transform();
  const Vec3 last_gradient = derivative(kMaxNodes);
  for (int k = 0; k < kMaxNodes; ++k) {
    result.weight_gradients[k] = sub(derivative(k), last_gradient);
    sum = mul_add(weights.values[k], nodes.transform[k], sum);
  }
  result.blend = Blend(sum);
  return result;
}

struct WarpWithJacobian {
  Vec3 point;
  Vec3 columns[3]; ///< of the derivative by the canonical point
};

HWY_INLINE WarpWithJacobian warp_with_jacobian(const Nodes& nodes, const BlendAt& there, const Vec3& at) {
  WarpWithJacobian warped;
  Vec3 half_rotated;
  const Quat& r = there.blend.real;
  const Quat& d = there.blend.dual;
  const F factor = there.blend.twice_inverse_norm;
  const Vec3 shift = displacement(r, d, at, half_rotated);
  warped.point = mul_add(factor, shift, at);
  const F one = constant(1);
  const Vec3 axes[3] = {{one, zero(), zero()}, {zero(), one, zero()}, {zero(), zero(), one}};
  const Vec3 inner = add(half_rotated, d.v);
  for (int a = 0; a < 3; ++a) {
    DualQuat by_point = no_transform();
    for (int k = 0; k < kMaxNodes; ++k) {
      const Vec3& gradients = there.weight_gradients[k];
      by_point = mul_add(a == 0 ? gradients.x : a == 1 ? gradients.y : gradients.z, nodes.transform[k], by_point);
    }
    const Quat& dr = by_point.real;
    const Quat& dd = by_point.dual;
    // The product rule over displacement(), then over its factor.
    const Vec3 inner_derivative =
        add(add(mul_add(dr.w, at, cross(dr.v, at)), mul_add(r.w, axes[a], cross(r.v, axes[a]))), dd.v);
    Vec3 derivative = add(cross(dr.v, inner), cross(r.v, inner_derivative));
    derivative = mul_add(dr.w, d.v, mul_add(r.w, dd.v, derivative));
    derivative = sub(derivative, mul_add(dd.w, r.v, mul(d.w, dr.v)));
    const F shrink = hn::Mul(factor, dot(r, dr));
    warped.columns[a] = mul_add(factor, sub(derivative, mul(shrink, shift)), axes[a]);
  }
  return warped;
}

/// The inverse of the warp at one point.
struct InverseWarp {
  Vec3 point;
  Vec3 direction; ///< of what was asked for
  Mask found;
  Quat rotation; ///< there, to the world
};

/// Newton's method from `start`. Nodes are looked for again once the point has gone farther than changes them.
HWY_NOINLINE InverseWarp inverse_warp(const NodeMotion& motion, const Vec3& world, const Vec3& direction,
                                      const Vec3& start) {
  constexpr int kSteps = 12;
  constexpr float kTolerance = 2e-5F;     // metres that may be left
  constexpr float kQuadratic = 8e-4F;     // metres that one more step brings below that where the warp is regular
  constexpr float kSmallestVolume = 0.1F; // of what the warp makes of a unit: below, it folds
  const float radius_squared = 1 / motion.cells->inverse_squared_weight_radius;
  const F stale = constant(4e-4F * radius_squared);   // squared: a fiftieth of the weights' radius
  const F longest = constant(0.25F * radius_squared); // squared step
  InverseWarp back{start, direction, hn::Ne(zero(), zero()), {}};
  Nodes nodes;
  BlendAt there;
  Vec3 found_at = start;
  find_nodes(motion, start, nodes);
  for (int step = 0; step < kSteps; ++step) {
    there = blend_at(motion, nodes, back.point);
    const WarpWithJacobian warped = warp_with_jacobian(nodes, there, back.point);
    const Vec3 residual = sub(world, warped.point);
    const Vec3 travelled = sub(back.point, found_at);
    const Mask fresh = hn::Le(dot(travelled, travelled), stale);
    // Cofactors of the derivative.
    const Vec3 c0 = cross(warped.columns[1], warped.columns[2]);
    const Vec3 c1 = cross(warped.columns[2], warped.columns[0]);
    const Vec3 c2 = cross(warped.columns[0], warped.columns[1]);
    const F volume = dot(warped.columns[0], c0);
    const Mask regular = hn::Gt(volume, constant(kSmallestVolume));
    const F inverse_volume = hn::Div(constant(1), hn::IfThenElse(regular, volume, constant(1)));
    const auto inverse_jacobian_times = [&](const Vec3& v) {
      const Vec3 solved{hn::Mul(inverse_volume, dot(c0, v)), hn::Mul(inverse_volume, dot(c1, v)),
                        hn::Mul(inverse_volume, dot(c2, v))};
      return choose(regular, solved, there.blend.inverse_rotate(v));
    };
    back.direction = inverse_jacobian_times(direction);
    const F tolerance = hn::IfThenElse(regular, constant(kQuadratic * kQuadratic), constant(kTolerance * kTolerance));
    const Mask close = hn::And(nodes.present[0], hn::Le(dot(residual, residual), tolerance));
    back.found = hn::And(fresh, close);
    const Mask finished = hn::Or(back.found, hn::Not(nodes.present[0]));
    Vec3 by = inverse_jacobian_times(residual);
    const F length = dot(by, by);
    by = mul(hn::Min(constant(1), hn::Sqrt(hn::Div(longest, hn::Max(length, constant(1e-30F))))), by);
    back.point = choose(nodes.present[0], add(back.point, by), back.point);
    if (hn::AllTrue(Floats(), finished)) break;
    const Vec3 now_travelled = sub(back.point, found_at);
    if (!hn::AllTrue(Floats(), hn::Or(finished, hn::Le(dot(now_travelled, now_travelled), stale)))) {
      find_nodes(motion, back.point, nodes);
      found_at = back.point;
    }
  }
  back.rotation = there.blend.rotation();
  return back;
}

/// Structures of floats, field by field into lanes and back.
template <int kFields> struct Lanes {
  static constexpr std::size_t kCount = hn::MaxLanes(Floats());
  HWY_ALIGN float values[kFields][kCount] = {};

  HWY_INLINE F field(int f) const { return hn::Load(Floats(), values[f]); }
  HWY_INLINE Vec3 field3(int f) const { return {field(f), field(f + 1), field(f + 2)}; }
  HWY_INLINE void set(int f, F value) { hn::Store(value, Floats(), values[f]); }
  HWY_INLINE void set3(int f, const Vec3& v) {
    set(f, v.x);
    set(f + 1, v.y);
    set(f + 2, v.z);
  }
};

/// Where the node alone would have a world point from.
HWY_INLINE Vec3 start_at(const NodeMotion& motion, I node, const Vec3& world) {
  return Blend::of_unit(gather_transforms(motion.transforms, node)).inverse_apply(world);
}

void rays_to_canonical_at(const NodeMotion& motion, const Ray* rays, std::size_t count, CanonicalRay* out) {
  const Ints di;
  Lanes<7> in;
  HWY_ALIGN std::int32_t starts[Lanes<7>::kCount];
  for (std::size_t i = 0; i < Lanes<7>::kCount; ++i) {
    const Ray& ray = rays[i < count ? i : 0];
    for (std::size_t a = 0; a < 3; ++a) {
      in.values[a][i] = ray.point[a];
      in.values[3 + a][i] = ray.direction[a];
    }
    in.values[6][i] = ray.reach;
    starts[i] = ray.start;
  }
  const Vec3 world = in.field3(0);
  const Vec3 direction = in.field3(3);
  constexpr float kOuter = 0.8F; // of the reach: where half a parabola through it errs least over the whole
  const F outer = hn::Mul(constant(kOuter), in.field(6));
  const InverseWarp middle = inverse_warp(motion, world, direction, start_at(motion, hn::Load(di, starts), world));
  const Vec3 ahead = mul(outer, middle.direction);
  // What is not near the straight line belongs to another part of the surface.
  const F far_off = dot(ahead, ahead);
  const F per_square = hn::Div(constant(1), hn::Max(hn::Mul(outer, outer), constant(1e-12F)));
  const auto fit_curvature = [&](const Vec3& from_point, F t) {
    const Vec3 straight = add(middle.point, from_point);
    const InverseWarp end = inverse_warp(motion, mul_add(t, direction, world), direction, straight);
    const Vec3 off = sub(end.point, straight);
    const Mask fits = hn::And(end.found, hn::Le(dot(off, off), far_off));
    return mul(hn::IfThenElseZero(fits, per_square), off);
  };
  const F nothing = hn::NaN(Floats());
  Lanes<16> result;
  result.set3(0, choose(middle.found, middle.point, {nothing, nothing, nothing}));
  result.set3(3, middle.direction);
  result.set3(6, fit_curvature(mul(constant(-1), ahead), hn::Neg(outer)));
  result.set3(9, fit_curvature(ahead, outer));
  result.set3(12, middle.rotation.v);
  result.set(15, middle.rotation.w);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t a = 0; a < 3; ++a) {
      out[i].point[a] = result.values[a][i];
      out[i].direction[a] = result.values[3 + a][i];
      out[i].curvatures[0][a] = result.values[6 + a][i];
      out[i].curvatures[1][a] = result.values[9 + a][i];
    }
    for (std::size_t a = 0; a < 4; ++a) out[i].rotation[a] = result.values[12 + a][i];
  }
}

void rays_to_canonical(const NodeMotion& motion, const Ray* rays, std::size_t count, CanonicalRay* out) {
  const std::size_t lanes = hn::Lanes(Floats());
  for (std::size_t i = 0; i < count; i += lanes)
    rays_to_canonical_at(motion, rays + i, HWY_MIN(lanes, count - i), out + i);
}

void points_to_world(const NodeMotion& motion, const std::array<float, 3>* canonical, std::size_t count,
                     WarpedPoint* world) {
  const std::size_t lanes = hn::Lanes(Floats());
  for (std::size_t begin = 0; begin < count; begin += lanes) {
    const std::size_t here = HWY_MIN(lanes, count - begin);
    Lanes<3> in;
    for (std::size_t i = 0; i < lanes; ++i) {
      for (std::size_t a = 0; a < 3; ++a) in.values[a][i] = canonical[begin + (i < here ? i : 0)][a];
    }
    const Vec3 at = in.field3(0);
    Nodes nodes;
    find_nodes(motion, at, nodes);
    const Blend blend = blend_at(motion, nodes, at).blend;
    const F nothing = hn::NaN(Floats());
    const Quat rotation = blend.rotation();
    Lanes<7> out;
    out.set3(0, choose(nodes.present[0], blend.apply(at), {nothing, nothing, nothing}));
    out.set3(3, rotation.v);
    out.set(6, rotation.w);
    for (std::size_t i = 0; i < here; ++i) {
      for (std::size_t a = 0; a < 3; ++a) world[begin + i].point[a] = out.values[a][i];
      for (std::size_t a = 0; a < 4; ++a) world[begin + i].rotation[a] = out.values[3 + a][i];
    }
  }
}

} // namespace kinora::motion::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::motion::kernels {

HWY_EXPORT(rays_to_canonical);
HWY_EXPORT(points_to_world);

void rays_to_canonical(const NodeMotion& motion, std::span<const Ray> rays, CanonicalRay* canonical) {
  HWY_DYNAMIC_DISPATCH(rays_to_canonical)(motion, rays.data(), rays.size(), canonical);
}

void points_to_world(const NodeMotion& motion, std::span<const std::array<float, 3>> canonical, WarpedPoint* world) {
  HWY_DYNAMIC_DISPATCH(points_to_world)(motion, canonical.data(), canonical.size(), world);
}

} // namespace kinora::motion::kernels
#endif
