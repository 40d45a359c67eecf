#include "tracking/body/body_match.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tracking/body/body_match_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

#include "core/vectors_simd.h"

#ifndef KINORA_TRACKING_BODY_MATCH_ONCE
#define KINORA_TRACKING_BODY_MATCH_ONCE
namespace kinora::tracking {

/// PartShape and the way from the camera into its bone, as kernels read them.
struct FloatPart {
  Eigen::Matrix3f rotation;
  Eigen::Vector3f translation, a, axis, centre; ///< the centre in the camera
  float radius, length, sin_half_angle, tan_half_angle, narrowing, reach;
};

} // namespace kinora::tracking
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace vectors::HWY_NAMESPACE;

HWY_INLINE Vec3 constants(const Eigen::Vector3f& v) { return {constant(v.x()), constant(v.y()), constant(v.z())}; }

HWY_INLINE Vec3 rotated(const Eigen::Matrix3f& by, const Vec3& v) {
  return mul_add(v.x, constants(by.col(0)), mul_add(v.y, constants(by.col(1)), mul(v.z, constants(by.col(2)))));
}

/// Some points and the part that explains each best so far.
struct BestParts {
  Vec3 position, normal;
  F cost;
  I part;
};

/// As closest_surface() and BodyInCamera::match() have it.
HWY_INLINE void match_part(const FloatPart& part, std::int32_t number, F normal_cost, BestParts& best) {
  const Floats df;
  const F one = constant(1);
  const Vec3 from_centre = sub(best.position, constants(part.centre));
  const F farthest = hn::Add(constant(part.reach), hn::Sqrt(best.cost));
  const Mask near = hn::Lt(dot(from_centre, from_centre), hn::Mul(farthest, farthest));
  if (hn::AllFalse(df, near)) return;
  const F narrowing = constant(part.narrowing);
  const Vec3 in_bone = add(rotated(part.rotation, best.position), constants(part.translation));
  const Vec3 from_a = sub({hn::Mul(narrowing, in_bone.x), in_bone.y, in_bone.z}, constants(part.a));
  const Vec3 axis = constants(part.axis);
  const F height = dot(from_a, axis);
  const F across = hn::Sqrt(hn::Max(zero(), hn::NegMulAdd(height, height, dot(from_a, from_a))));
  const F axial = hn::NegMulAdd(across, constant(part.tan_half_angle), height);
  const F reached = hn::Min(hn::Max(axial, zero()), constant(part.length));
  const Vec3 offset = mul_add(hn::Neg(reached), axis, from_a);
  const F distance = hn::Max(hn::Sqrt(dot(offset, offset)), constant(1e-9F));
  const F radius = hn::NegMulAdd(reached, constant(part.sin_half_angle), constant(part.radius));
  const Vec3 gradient{hn::Mul(narrowing, offset.x), offset.y, offset.z}; // times the distance
  const F flatness = hn::Div(one, hn::Max(hn::Sqrt(dot(gradient, gradient)), constant(1e-9F)));
  const F to_surface = hn::Mul(hn::Sub(distance, radius), hn::Mul(flatness, distance));
  const F cosine = hn::Mul(flatness, dot(gradient, rotated(part.rotation, best.normal)));
  const F cost = hn::MulAdd(normal_cost, hn::Sub(one, cosine), hn::Mul(to_surface, to_surface));
  const Mask better = hn::And(near, hn::And(hn::Ge(cosine, zero()), hn::Lt(cost, best.cost)));
  best.cost = hn::IfThenElse(better, cost, best.cost);
  best.part = hn::IfThenElse(hn::RebindMask(Ints(), better), hn::Set(Ints(), number), best.part);
}

void match_in_lanes(const FloatPart* body, const MeasuredPoint* points, std::size_t count, float normal_cost,
                    float max_cost, const std::array<bool, kBodyParts>& takes_part, PartMatch* matches) {
  const Floats df;
  const Ints di;
  for (std::size_t begin = 0; begin < count; begin += hn::Lanes(df)) {
    HWY_ALIGN float values[6][hn::MaxLanes(df)];
    HWY_ALIGN std::int32_t found[hn::MaxLanes(df)];
    HWY_ALIGN float costs[hn::MaxLanes(df)];
    for (std::size_t lane = 0; lane < hn::Lanes(df); ++lane) {
      const MeasuredPoint& point = points[HWY_MIN(begin + lane, count - 1)];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        values[axis][lane] = static_cast<float>(point.position[static_cast<Eigen::Index>(axis)]);
        values[3 + axis][lane] = static_cast<float>(point.normal[static_cast<Eigen::Index>(axis)]);
      }
    }
    const auto load = [&](std::size_t first) {
      return Vec3{hn::Load(df, values[first]), hn::Load(df, values[first + 1]), hn::Load(df, values[first + 2])};
    };
    BestParts best{load(0), load(3), constant(max_cost), hn::Set(di, -1)};
    for (std::size_t part = 0; part < kBodyParts; ++part) {
      if (takes_part[part]) match_part(body[part], static_cast<std::int32_t>(part), constant(normal_cost), best);
    }
    hn::Store(best.part, di, found);
    hn::Store(best.cost, df, costs);
    for (std::size_t lane = 0; lane < HWY_MIN(count - begin, hn::Lanes(df)); ++lane) {
      matches[begin + lane] = {found[lane], costs[lane]};
    }
  }
}

} // namespace kinora::tracking::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::tracking {

HWY_EXPORT(match_in_lanes);

void match_points(const BodyInCamera& body, std::span<const MeasuredPoint> points, double normal_length,
                  double max_cost, std::span<PartMatch> matches) {
  std::array<bool, kBodyParts> all;
  all.fill(true);
  match_points(body, points, normal_length, max_cost, all, matches);
}

void match_points(const BodyInCamera& body, std::span<const MeasuredPoint> points, double normal_length,
                  double max_cost, const std::array<bool, kBodyParts>& takes_part, std::span<PartMatch> matches) {
  std::array<FloatPart, kBodyParts> floats;
  for (std::size_t i = 0; i < kBodyParts; ++i) {
    const PartShape& part = body.body().parts[i];
    const SE3& to_bone = body.to_bone(i);
    floats[i] = {to_bone.linear().cast<float>(),
                 to_bone.translation().cast<float>(),
                 part.a.cast<float>(),
                 part.axis.cast<float>(),
                 (body.bone(i) * part.centre).cast<float>(),
                 static_cast<float>(part.radius_a),
                 static_cast<float>(part.length),
                 static_cast<float>(part.sin_half_angle),
                 static_cast<float>(part.tan_half_angle),
                 static_cast<float>(1 / part.width),
                 static_cast<float>(part.reach)};
  }
  HWY_DYNAMIC_DISPATCH(match_in_lanes)
  (floats.data(), points.data(), points.size(), static_cast<float>(normal_length * normal_length),
   static_cast<float>(max_cost), takes_part, matches.data());
}

} // namespace kinora::tracking
#endif
