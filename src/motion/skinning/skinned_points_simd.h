// Blends of a layer's points in lanes, for *_simd.cpp after <hwy/foreach_target.h>.
#if defined(KINORA_MOTION_SKINNING_SKINNED_POINTS_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_MOTION_SKINNING_SKINNED_POINTS_SIMD_H
#undef KINORA_MOTION_SKINNING_SKINNED_POINTS_SIMD_H
#else
#define KINORA_MOTION_SKINNING_SKINNED_POINTS_SIMD_H
#endif

#include "motion/skinning/layer_pose.h"
#include "motion/skinning/skinning_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::skinning::HWY_NAMESPACE {

/// The transforms of the nodes that carry each lane's point, weighed, in the hemisphere of the heaviest, and their sum.
struct WeightedTransforms {
  DualQuat of_node[kMaxNodes];
  DualQuat sum;
};

/// `points`: at least `count` > 0 of them.
HWY_INLINE WeightedTransforms weighted_transforms(const motion::SkinnedPoint* points, std::size_t count,
                                                  const TransformRow* nodes) {
  WeightedTransforms weighted;
  const Quat weights = load_rows([&](std::size_t lane) { return points[item_of(lane, count)].weights.data(); });
  const F of_node[kMaxNodes] = {weights.v.x, weights.v.y, weights.v.z, weights.w};
  Quat heaviest;
  for (std::size_t k = 0; k < kMaxNodes; ++k) {
    const DualQuat transform =
        load_transforms(nodes, [&](std::size_t lane) { return points[item_of(lane, count)].nodes[k]; });
    if (k == 0) heaviest = transform.real;
    const F weight = in_hemisphere(of_node[k], transform.real, heaviest);
    weighted.of_node[k] = mul(weight, transform);
    weighted.sum = k == 0 ? weighted.of_node[0] : mul_add(weight, transform, weighted.sum);
  }
  return weighted;
}

} // namespace kinora::skinning::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
