#include "tracking/bulk_warp_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tracking/bulk_warp_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>
// after highway.h
#include <hwy/contrib/math/math-inl.h>

#include "core/vectors_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace vectors::HWY_NAMESPACE;

constexpr int kMost = Influence::kMost;
constexpr int kWeighed = kMost + 1; // the last has no say, but its weight is taken from the others
constexpr std::int32_t kSlotBits = 0xFF;

/// The nodes that move each lane's point, nearest first, and the first that does not.
struct Nodes {
  Vec3 position[kWeighed];
  Mask present[kWeighed];
  Quat real[kMost], dual[kMost]; ///< in the hemisphere of the nearest
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

  // The lowest bits of a squared distance say which candidate it is: then the nearest are found with min and max alone.
  const I slots = hn::Set(di, kSlotBits);
  const F none = hn::BitCast(df, hn::Or(hn::BitCast(di, constant(cells.squared_influence_radius)), slots));
  F nearest[kWeighed] = {none, none, none, none, none};
  const std::int32_t* candidates = cells.candidates.data();
  const float* positions = cells.positions.data();
  for (std::int32_t slot = 0; slot < most; ++slot) {
    const auto present = hn::Lt(hn::Set(di, slot), count);
    HWY_ALIGN std::int32_t candidate[hn::MaxLanes(di)];
    hn::Store(hn::IfThenElseZero(present, hn::Add(first, hn::Set(di, slot))), di, candidate);
    const Vec3 position =
        load_rows([&](std::size_t lane) { return positions + 4 * std::ptrdiff_t{candidates[candidate[lane]]}; }).v;
    const Vec3 offset = sub(at, position);
    const I key = hn::Or(hn::AndNot(slots, hn::BitCast(di, dot(offset, offset))), hn::Set(di, slot));
    F distance = hn::IfThenElse(hn::RebindMask(df, present), hn::BitCast(df, key), none);
    for (F& kept : nearest) {
      const F nearer = hn::Min(kept, distance);
      distance = hn::Max(kept, distance);
      kept = nearer;
    }
  }
  for (int k = 0; k < kWeighed; ++k) {
    const I slot = hn::And(hn::BitCast(di, nearest[k]), slots);
    const auto present = hn::Ne(slot, slots);
    nodes.present[k] = hn::RebindMask(df, present);
    const I node = hn::GatherIndex(di, cells.candidates.data(), hn::IfThenElseZero(present, hn::Add(first, slot)));
    nodes.position[k] = gather4(cells.positions.data(), hn::ShiftLeft<2>(node)).v;
    if (k == kMost) break;
    const I transform = hn::ShiftLeft<3>(node);
    nodes.real[k] = gather4(motion.transforms, transform);
    nodes.dual[k] = gather4(motion.transforms + 4, transform);
    const Mask flipped = hn::Lt(dot(nodes.real[k], nodes.real[0]), zero());
    const F sign = hn::IfThenElse(flipped, constant(-1), constant(1));
    nodes.real[k] = {mul(sign, nodes.real[k].v), hn::Mul(sign, nodes.real[k].w)};
    nodes.dual[k] = {mul(sign, nodes.dual[k].v), hn::Mul(sign, nodes.dual[k].w)};
  }
}

/// The blend of the nodes' transforms at a point: not normalised; what it does does not depend on its scale.
struct Blend {
  F weights[kMost];
  Vec3 weight_slopes[kMost]; ///< by the point
  Quat real, dual;
  F twice_inverse_norm; ///< 2 / |real|²
};

HWY_INLINE void blend_at(const NodeMotion& motion, const Nodes& nodes, const Vec3& at, Blend& blend) {
  const Floats df;
  const F inverse = constant(motion.cells->inverse_squared_weight_radius);
  const F reach = constant(motion.cells->squared_influence_radius);
  F nearest = zero();
  F weights[kWeighed];
  Vec3 slopes[kWeighed];
  for (int k = 0; k < kWeighed; ++k) {
    const Vec3 offset = sub(at, nodes.position[k]);
    const F squared = hn::IfThenElse(nodes.present[k], dot(offset, offset), reach);
    if (k == 0) nearest = squared;
    weights[k] = hn::Exp(df, hn::Mul(hn::Sub(nearest, squared), inverse));
    slopes[k] = mul(hn::IfThenElseZero(nodes.present[k], hn::Mul(hn::Mul(constant(-2), inverse), weights[k])), offset);
  }
  for (int k = 0; k < kMost; ++k) {
    blend.weights[k] = hn::Sub(weights[k], weights[kMost]);
    blend.weight_slopes[k] = sub(slopes[k], slopes[kMost]);
  }
  // All nodes equally far: the nearest moves the point alone.
  blend.weights[0] = hn::Max(blend.weights[0], constant(1e-6F));
  blend.real = blend.dual = {{zero(), zero(), zero()}, zero()};
  for (int k = 0; k < kMost; ++k) {
    blend.real = mul_add(blend.weights[k], nodes.real[k], blend.real);
    blend.dual = mul_add(blend.weights[k], nodes.dual[k], blend.dual);
  }
  blend.twice_inverse_norm = hn::Div(constant(2), dot(blend.real, blend.real));
}

HWY_INLINE Vec3 rotated_back(const Blend& blend, const Vec3& v) {
  const Vec3 turned = sub(mul(blend.real.w, v), cross(blend.real.v, v));
  return sub(v, mul(blend.twice_inverse_norm, cross(blend.real.v, turned)));
}

/// The rotation of a blend as a unit quaternion.
HWY_INLINE Quat unit(const Blend& blend) {
  const F to_unit = hn::Sqrt(hn::Mul(constant(0.5F), blend.twice_inverse_norm));
  return {mul(to_unit, blend.real.v), hn::Mul(to_unit, blend.real.w)};
}

struct Moved {
  Vec3 point;
  Vec3 columns[3]; ///< of the derivative by the canonical point
};

HWY_INLINE Moved move_with_derivative(const Nodes& nodes, const Blend& blend, const Vec3& at) {
  Moved moved;
  Vec3 turned;
  const Quat& r = blend.real;
  const Quat& d = blend.dual;
  const Vec3 shift = displacement(r, d, at, turned);
  moved.point = mul_add(blend.twice_inverse_norm, shift, at);
  const F one = constant(1);
  const Vec3 axes[3] = {{one, zero(), zero()}, {zero(), one, zero()}, {zero(), zero(), one}};
  const Vec3 inner = add(turned, d.v);
  for (int a = 0; a < 3; ++a) {
    Quat dr{{zero(), zero(), zero()}, zero()};
    Quat dd = dr;
    for (int k = 0; k < kMost; ++k) {
      const Vec3& slopes = blend.weight_slopes[k];
      const F slope = a == 0 ? slopes.x : a == 1 ? slopes.y : slopes.z;
      dr = mul_add(slope, nodes.real[k], dr);
      dd = mul_add(slope, nodes.dual[k], dd);
    }
    // The product rule over displacement(), then over its factor.
    const Vec3 inner_slope =
        add(add(mul_add(dr.w, at, cross(dr.v, at)), mul_add(r.w, axes[a], cross(r.v, axes[a]))), dd.v);
    Vec3 slope = add(cross(dr.v, inner), cross(r.v, inner_slope));
    slope = mul_add(dr.w, d.v, mul_add(r.w, dd.v, slope));
    slope = sub(slope, mul_add(dd.w, r.v, mul(d.w, dr.v)));
    const F shrink = hn::Mul(blend.twice_inverse_norm, dot(r, dr));
    moved.columns[a] = mul_add(blend.twice_inverse_norm, sub(slope, mul(shrink, shift)), axes[a]);
  }
  return moved;
}

/// The inverse of the warp at one point.
struct WayBack {
  Vec3 point;
  Vec3 direction; ///< of what was asked for
  Mask found;
  Quat rotation; ///< there, to the world
};

/// Newton's method from `start`. Nodes are looked for again once the point has gone farther than changes them.
HWY_NOINLINE WayBack way_back(const NodeMotion& motion, const Vec3& world, const Vec3& direction, const Vec3& start) {
  constexpr int kSteps = 12;
  constexpr float kTolerance = 2e-5F;     // metres that may be left
  constexpr float kQuadratic = 8e-4F;     // metres that one more step brings below that where the warp is regular
  constexpr float kSmallestVolume = 0.1F; // of what the warp makes of a unit: below, it folds
  const float radius_squared = 1 / motion.cells->inverse_squared_weight_radius;
  const F stale = constant(4e-4F * radius_squared);   // squared: a fiftieth of the weights' radius
  const F longest = constant(0.25F * radius_squared); // squared step
  WayBack back{start, direction, hn::Ne(zero(), zero()), {}};
  Nodes nodes;
  Blend blend;
  Vec3 found_at = start;
  find_nodes(motion, start, nodes);
  for (int step = 0; step < kSteps; ++step) {
    blend_at(motion, nodes, back.point, blend);
    const Moved moved = move_with_derivative(nodes, blend, back.point);
    const Vec3 miss = sub(world, moved.point);
    const Vec3 gone = sub(back.point, found_at);
    const Mask fresh = hn::Le(dot(gone, gone), stale);
    // Cofactors of the derivative.
    const Vec3 c0 = cross(moved.columns[1], moved.columns[2]);
    const Vec3 c1 = cross(moved.columns[2], moved.columns[0]);
    const Vec3 c2 = cross(moved.columns[0], moved.columns[1]);
    const F volume = dot(moved.columns[0], c0);
    const Mask regular = hn::Gt(volume, constant(kSmallestVolume));
    const F inverse_volume = hn::Div(constant(1), hn::IfThenElse(regular, volume, constant(1)));
    const auto pull_back = [&](const Vec3& v) {
      const Vec3 solved{hn::Mul(inverse_volume, dot(c0, v)), hn::Mul(inverse_volume, dot(c1, v)),
                        hn::Mul(inverse_volume, dot(c2, v))};
      return choose(regular, solved, rotated_back(blend, v));
    };
    back.direction = pull_back(direction);
    const F tolerance = hn::IfThenElse(regular, constant(kQuadratic * kQuadratic), constant(kTolerance * kTolerance));
    const Mask close = hn::And(nodes.present[0], hn::Le(dot(miss, miss), tolerance));
    back.found = hn::And(fresh, close);
    const Mask finished = hn::Or(back.found, hn::Not(nodes.present[0]));
    Vec3 by = pull_back(miss);
    const F length = dot(by, by);
    by = mul(hn::Min(constant(1), hn::Sqrt(hn::Div(longest, hn::Max(length, constant(1e-30F))))), by);
    back.point = choose(nodes.present[0], add(back.point, by), back.point);
    if (hn::AllTrue(Floats(), finished)) break;
    const Vec3 now_gone = sub(back.point, found_at);
    if (!hn::AllTrue(Floats(), hn::Or(finished, hn::Le(dot(now_gone, now_gone), stale)))) {
      find_nodes(motion, back.point, nodes);
      found_at = back.point;
    }
  }
  back.rotation = unit(blend);
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
  const I transform = hn::ShiftLeft<3>(node);
  const Quat r = gather4(motion.transforms, transform);
  const Quat d = gather4(motion.transforms + 4, transform);
  const F two = constant(2);
  const Vec3 translation = mul(two, add(sub(mul(r.w, d.v), mul(d.w, r.v)), cross(r.v, d.v)));
  const Vec3 v = sub(world, translation);
  return sub(v, mul(two, cross(r.v, sub(mul(r.w, v), cross(r.v, v)))));
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
  const WayBack middle = way_back(motion, world, direction, start_at(motion, hn::Load(di, starts), world));
  const Vec3 ahead = mul(outer, middle.direction);
  // What is not near the straight line belongs to another part of the surface.
  const F far_off = dot(ahead, ahead);
  const F per_square = hn::Div(constant(1), hn::Max(hn::Mul(outer, outer), constant(1e-12F)));
  const auto bend_to = [&](const Vec3& from_point, F t) {
    const Vec3 straight = add(middle.point, from_point);
    const WayBack end = way_back(motion, mul_add(t, direction, world), direction, straight);
    const Vec3 off = sub(end.point, straight);
    const Mask fits = hn::And(end.found, hn::Le(dot(off, off), far_off));
    return mul(hn::IfThenElseZero(fits, per_square), off);
  };
  const F nothing = hn::NaN(Floats());
  Lanes<16> result;
  result.set3(0, choose(middle.found, middle.point, {nothing, nothing, nothing}));
  result.set3(3, middle.direction);
  result.set3(6, bend_to(mul(constant(-1), ahead), hn::Neg(outer)));
  result.set3(9, bend_to(ahead, outer));
  result.set3(12, middle.rotation.v);
  result.set(15, middle.rotation.w);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t a = 0; a < 3; ++a) {
      out[i].point[a] = result.values[a][i];
      out[i].direction[a] = result.values[3 + a][i];
      out[i].bends[0][a] = result.values[6 + a][i];
      out[i].bends[1][a] = result.values[9 + a][i];
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
                     Carried* world) {
  const std::size_t lanes = hn::Lanes(Floats());
  for (std::size_t begin = 0; begin < count; begin += lanes) {
    const std::size_t here = HWY_MIN(lanes, count - begin);
    Lanes<3> in;
    for (std::size_t i = 0; i < lanes; ++i) {
      for (std::size_t a = 0; a < 3; ++a) in.values[a][i] = canonical[begin + (i < here ? i : 0)][a];
    }
    const Vec3 at = in.field3(0);
    Nodes nodes;
    Blend blend;
    Vec3 turned;
    find_nodes(motion, at, nodes);
    blend_at(motion, nodes, at, blend);
    const Vec3 moved = mul_add(blend.twice_inverse_norm, displacement(blend.real, blend.dual, at, turned), at);
    const F nothing = hn::NaN(Floats());
    const Quat rotation = unit(blend);
    Lanes<7> out;
    out.set3(0, choose(nodes.present[0], moved, {nothing, nothing, nothing}));
    out.set3(3, rotation.v);
    out.set(6, rotation.w);
    for (std::size_t i = 0; i < here; ++i) {
      for (std::size_t a = 0; a < 3; ++a) world[begin + i].point[a] = out.values[a][i];
      for (std::size_t a = 0; a < 4; ++a) world[begin + i].rotation[a] = out.values[3 + a][i];
    }
  }
}

} // namespace kinora::tracking::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::tracking::kernels {

HWY_EXPORT(rays_to_canonical);
HWY_EXPORT(points_to_world);

void rays_to_canonical(const NodeMotion& motion, std::span<const Ray> rays, CanonicalRay* canonical) {
  HWY_DYNAMIC_DISPATCH(rays_to_canonical)(motion, rays.data(), rays.size(), canonical);
}

void points_to_world(const NodeMotion& motion, std::span<const std::array<float, 3>> canonical, Carried* world) {
  HWY_DYNAMIC_DISPATCH(points_to_world)(motion, canonical.data(), canonical.size(), world);
}

} // namespace kinora::tracking::kernels
#endif
