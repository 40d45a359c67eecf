#include "motion/skinning/skinned_lanes.h"

#include "motion/skinning/node_candidates.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "motion/skinning/skinned_lanes_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

#include "motion/skinning/skinning_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::motion::HWY_NAMESPACE {
using namespace skinning::HWY_NAMESPACE;

constexpr std::size_t kPoints = PointLanes::kPoints;

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

void skinning_weights_in_lanes(const CandidateNodes& nodes, const PointLanes& points, InfluenceLanes& influences) {
  constexpr std::int32_t kNone = NodeCandidates::kMax;
  const Floats df;
  const Ints di;
  const float reach = nodes.influence_radius * nodes.influence_radius;
  for (std::size_t first = 0; first < kPoints; first += hn::Lanes(df)) {
    const Vec3 at = load(points, first);
    NearestNodes<kNone> nearest(reach);
    for (std::size_t slot = 0; slot < nodes.nodes.size(); ++slot) {
      const PositionRow& position = nodes.positions[nodes.nodes[slot]];
      const Vec3 offset = sub(at, {constant(position[0]), constant(position[1]), constant(position[2])});
      nearest.add(dot(offset, offset), static_cast<std::int32_t>(slot));
    }
    I node[kNearestNodes];
    F squared[kNearestNodes];
    Mask present[kNearestNodes];
    for (int k = 0; k < kNearestNodes; ++k) {
      const I slot = nearest.number(k);
      const auto is_node = hn::Ne(slot, hn::Set(di, kNone));
      present[k] = hn::RebindMask(df, is_node);
      if (hn::AllFalse(di, is_node)) {
        node[k] = hn::Zero(di);
        squared[k] = constant(reach);
        continue;
      }
      node[k] = hn::IfThenElseZero(is_node, hn::GatherIndex(di, nodes.nodes.data(), hn::IfThenElseZero(is_node, slot)));
      const Vec3 offset = sub(at, gather_positions(nodes.positions, node[k]));
      squared[k] = hn::IfThenElse(present[k], dot(offset, offset), constant(reach));
    }
    NodeWeights weights = skinning_weights_of(squared, 1 / (nodes.weight_radius * nodes.weight_radius));
    F total = zero();
    for (int k = 0; k < kMaxNodes; ++k) {
      weights.values[k] = hn::IfThenElseZero(present[k], hn::Max(weights.values[k], zero()));
      total = hn::Add(total, weights.values[k]);
    }
    const F share = hn::Div(constant(1), hn::IfThenElse(present[0], total, constant(1)));
    for (int k = 0; k < kMaxNodes; ++k) {
      hn::StoreU(hn::Mul(weights.values[k], share), df, influences.weights[static_cast<std::size_t>(k)].data() + first);
      hn::StoreU(node[k], di, influences.nodes[static_cast<std::size_t>(k)].data() + first);
    }
  }
}

HWY_INLINE Blend blend_lanes(const TransformRow* transforms, const InfluenceLanes& influences, std::size_t first) {
  return Blend(weighted_sum(
      [&](std::size_t k) HWY_ATTR { return hn::LoadU(Floats(), influences.weights[k].data() + first); },
      [&](std::size_t k)
          HWY_ATTR { return gather_transforms(transforms, hn::LoadU(Ints(), influences.nodes[k].data() + first)); }));
}

void skin_in_lanes(const TransformRow* transforms, const InfluenceLanes& influences, const PointLanes& points,
                   PointLanes& positions, const PointLanes* vectors, PointLanes* rotated) {
  for (std::size_t first = 0; first < kPoints; first += hn::Lanes(Floats())) {
    const Blend blend = blend_lanes(transforms, influences, first);
    store(blend.apply(load(points, first)), first, positions);
    if (vectors != nullptr) store(blend.rotate(load(*vectors, first)), first, *rotated);
  }
}

} // namespace kinora::motion::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::motion {

HWY_EXPORT(skinning_weights_in_lanes);
HWY_EXPORT(skin_in_lanes);

void InfluenceLanes::set(std::size_t point, const Influence& influence) {
  for (std::size_t k = 0; k < Influence::kMax; ++k) {
    const bool is_node = k < static_cast<std::size_t>(influence.count);
    nodes[k][point] = is_node ? influence.nodes[k] : 0;
    weights[k][point] = is_node ? static_cast<float>(influence.weights[k]) : 0.0F;
  }
}

Influence InfluenceLanes::at(std::size_t point) const {
  Influence influence;
  double total = 0;
  for (std::size_t k = 0; k < Influence::kMax && weights[k][point] > 0; ++k, ++influence.count) {
    influence.nodes[k] = nodes[k][point];
    total += influence.weights[k] = static_cast<double>(weights[k][point]);
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) influence.weights[k] /= total;
  return influence;
}

void skinning_weights(const CandidateNodes& nodes, const PointLanes& points, InfluenceLanes& influences) {
  HWY_DYNAMIC_DISPATCH(skinning_weights_in_lanes)(nodes, points, influences);
}

void skin_points(std::span<const TransformRow> transforms, const InfluenceLanes& influences, const PointLanes& points,
                 PointLanes& positions) {
  HWY_DYNAMIC_DISPATCH(skin_in_lanes)(transforms.data(), influences, points, positions, nullptr, nullptr);
}

void skin_points(std::span<const TransformRow> transforms, const InfluenceLanes& influences, const PointLanes& points,
                 PointLanes& positions, const PointLanes& vectors, PointLanes& rotated) {
  HWY_DYNAMIC_DISPATCH(skin_in_lanes)(transforms.data(), influences, points, positions, &vectors, &rotated);
}

} // namespace kinora::motion
#endif
