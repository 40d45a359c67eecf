#include "motion/skinning/layer_pose.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "motion/skinning/layer_pose_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

#include "motion/skinning/skinned_points_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::motion::HWY_NAMESPACE {
using namespace skinning::HWY_NAMESPACE;

void pose_points_in_lanes(const SkinnedPoint* points, std::size_t count, const TransformRow* nodes, PosedPoint* posed) {
  for (std::size_t begin = 0; begin < count; begin += hn::Lanes(Floats())) {
    const std::size_t here = HWY_MIN(count - begin, hn::Lanes(Floats()));
    const SkinnedPoint* from = points + begin;
    const NormalisedBlend blend(weighted_transforms(from, here, nodes).sum);
    const Vec3 position = load_rows([&](std::size_t lane) { return from[item_of(lane, here)].position.data(); }).v;
    const Vec3 normal = load_rows([&](std::size_t lane) { return from[item_of(lane, here)].normal.data(); }).v;
    store_rows({blend.apply(position), zero()}, here,
               [&](std::size_t lane) { return posed[begin + lane].position.data(); });
    store_rows({blend.rotate(normal), zero()}, here,
               [&](std::size_t lane) { return posed[begin + lane].normal.data(); });
  }
}

} // namespace kinora::motion::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::motion {

HWY_EXPORT(pose_points_in_lanes);

void pose_points(std::span<const SkinnedPoint> points, std::span<const TransformRow> nodes,
                 std::span<PosedPoint> posed) {
  HWY_DYNAMIC_DISPATCH(pose_points_in_lanes)(points.data(), points.size(), nodes.data(), posed.data());
}

} // namespace kinora::motion
#endif
