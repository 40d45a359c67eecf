#include "fields/brute_force.h"

#include "core/error.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/brute_force_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

#include "motion/skinning/skinning_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::bench::HWY_NAMESPACE {
using namespace skinning::HWY_NAMESPACE;

using Nodes = BruteForce::Nodes;

struct Nearest {
  I node[kNearestNodes]; // nearest first; the last has no say
  F squared[kNearestNodes];
};

Nearest find_nearest(const std::vector<motion::PositionRow>& positions, const Vec3& at) {
  constexpr float kAnywhere = 3e38F;
  NearestNodes<BruteForce::kMaxNodes> numbers(kAnywhere);
  for (std::size_t n = 0; n < positions.size(); ++n) {
    const motion::PositionRow& p = positions[n];
    const Vec3 offset = sub(at, {constant(p[0]), constant(p[1]), constant(p[2])});
    numbers.add(dot(offset, offset), static_cast<std::int32_t>(n));
  }
  Nearest nearest;
  for (int k = 0; k < kNearestNodes; ++k) {
    nearest.node[k] = numbers.number(k);
    const Vec3 offset = sub(at, gather_positions(positions.data(), nearest.node[k]));
    nearest.squared[k] = dot(offset, offset);
  }
  return nearest;
}

/// `less_the_first_without`: as DeformationGraph weighs.
Blend blend(const Nodes& nodes, Nearest nearest, bool less_the_first_without) {
  F& last = nearest.squared[kMaxNodes];
  last = hn::Min(last, constant(nodes.squared_influence_radius));
  const NodeWeights weights = skinning_weights_of(nearest.squared, nodes.inverse_squared_weight_radius);
  return Blend(weighted_sum(
      [&](std::size_t k)
          HWY_ATTR { return less_the_first_without ? hn::Max(weights.values[k], zero()) : weights.falloffs[k]; },
      [&](std::size_t k) HWY_ATTR { return gather_transforms(nodes.transforms.data(), nearest.node[k]); }));
}

/// Calls carry(world) for as many points at a time as there are lanes.
template <class Carry>
HWY_INLINE void for_lanes(const BruteForce::Point* world, std::size_t count, BruteForce::Point* canonical,
                          const Carry& carry) {
  const Floats df;
  constexpr std::size_t kLanes = hn::MaxLanes(Floats());
  for (std::size_t begin = 0; begin < count; begin += kLanes) {
    const std::size_t here = std::min(kLanes, count - begin);
    HWY_ALIGN float in[3][kLanes];
    for (std::size_t i = 0; i < kLanes; ++i) {
      for (std::size_t a = 0; a < 3; ++a) in[a][i] = world[begin + (i < here ? i : 0)][a];
    }
    const Vec3 found = carry(Vec3{hn::Load(df, in[0]), hn::Load(df, in[1]), hn::Load(df, in[2])});
    hn::Store(found.x, df, in[0]);
    hn::Store(found.y, df, in[1]);
    hn::Store(found.z, df, in[2]);
    for (std::size_t i = 0; i < here; ++i) {
      for (std::size_t a = 0; a < 3; ++a) canonical[begin + i][a] = in[a][i];
    }
  }
}

void by_live_nodes(const Nodes& nodes, const BruteForce::Point* world, std::size_t count,
                   BruteForce::Point* canonical) {
  for_lanes(world, count, canonical, [&](const Vec3& at) HWY_ATTR {
    return blend(nodes, find_nearest(nodes.live, at), false).inverse_apply(at);
  });
}

void exactly(const Nodes& nodes, const BruteForce::Point* world, std::size_t count, BruteForce::Point* canonical) {
  constexpr float kTolerance = 1e-4F;
  constexpr int kSteps = 12;
  for_lanes(world, count, canonical, [&](const Vec3& at) HWY_ATTR {
    const F nothing = hn::NaN(Floats());
    Vec3 position = blend(nodes, find_nearest(nodes.live, at), false).inverse_apply(at);
    Mask converged = hn::Ne(zero(), zero());
    for (int step = 0; step < kSteps; ++step) {
      const Blend here = blend(nodes, find_nearest(nodes.canonical, position), true);
      const Vec3 residual = sub(at, here.apply(position));
      converged = hn::Or(converged, hn::Lt(dot(residual, residual), constant(kTolerance * kTolerance)));
      if (hn::AllTrue(Floats(), converged)) break;
      position = choose(converged, position, add(position, here.inverse_rotate(residual)));
    }
    return choose(converged, position, {nothing, nothing, nothing});
  });
}

} // namespace kinora::bench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::bench {

HWY_EXPORT(by_live_nodes);
HWY_EXPORT(exactly);

BruteForce::BruteForce(const motion::DeformationGraph& graph, const motion::Warp& warp)
    : canonical_origin_(graph.nodes().front()), world_origin_(warp.node_positions().front()) {
  // The last number of the keys stands for no node; those that are weighed are always found.
  if (graph.nodes().size() > kMaxNodes || graph.nodes().size() < motion::Influence::kMax + 1) {
    throw Error(ErrorCode::kFailure, "the graph has too many nodes for this bench, or too few");
  }
  nodes_.canonical = motion::position_rows(graph.nodes(), canonical_origin_);
  nodes_.live = motion::position_rows(warp.node_positions(), world_origin_);
  nodes_.transforms = motion::transform_rows(warp.node_to_world(), canonical_origin_, world_origin_);
  nodes_.inverse_squared_weight_radius = static_cast<float>(1 / (graph.weight_radius() * graph.weight_radius()));
  nodes_.squared_influence_radius = static_cast<float>(graph.influence_radius() * graph.influence_radius());
}

void BruteForce::by_live_nodes(std::span<const Point> world, Point* canonical) const {
  HWY_DYNAMIC_DISPATCH(by_live_nodes)(nodes_, world.data(), world.size(), canonical);
}

void BruteForce::exactly(std::span<const Point> world, Point* canonical) const {
  HWY_DYNAMIC_DISPATCH(exactly)(nodes_, world.data(), world.size(), canonical);
}

} // namespace kinora::bench
#endif
