#include "tracking/layer_pose.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tracking/layer_pose_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

#include "tracking/point_blend_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::HWY_NAMESPACE {

void pose_points_in_lanes(const SkinnedPoint* points, std::size_t count, const NodeRow* nodes, PosedPoint* posed) {
  for (std::size_t begin = 0; begin < count; begin += hn::Lanes(Floats())) {
    const std::size_t here = HWY_MIN(count - begin, hn::Lanes(Floats()));
    const SkinnedPoint* from = points + begin;
    const Blend b = blend(from, here, nodes);
    const Quat& r = b.sum_real;
    const Quat& d = b.sum_dual;
    const Vec3 position = load_rows([&](std::size_t lane) { return from[item_of(lane, here)].position.data(); }).v;
    const Vec3 normal = load_rows([&](std::size_t lane) { return from[item_of(lane, here)].normal.data(); }).v;
    const Vec3 half_translation = add(sub(mul(r.w, d.v), mul(d.w, r.v)), cross(r.v, d.v));
    const Vec3 place = mul_add(constant(2), half_translation, rotated(r, position));
    store_rows({place, zero()}, here, [&](std::size_t lane) { return posed[begin + lane].place.data(); });
    store_rows({rotated(r, normal), zero()}, here, [&](std::size_t lane) { return posed[begin + lane].normal.data(); });
  }
}

} // namespace kinora::tracking::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::tracking {

HWY_EXPORT(pose_points_in_lanes);

void pose_points(std::span<const SkinnedPoint> points, std::span<const NodeRow> nodes, std::span<PosedPoint> posed) {
  HWY_DYNAMIC_DISPATCH(pose_points_in_lanes)(points.data(), points.size(), nodes.data(), posed.data());
}

} // namespace kinora::tracking
#endif
