#include "fields/brute_force.h"

#include "core/error.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/brute_force_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>
// after highway.h
#include <hwy/contrib/math/math-inl.h>

#include "core/vectors_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::bench::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace vectors::HWY_NAMESPACE;

using Nodes = BruteForce::Nodes;
constexpr int kBlended = 4;
constexpr std::int32_t kNumberBits = BruteForce::kMostNodes; // of a key: the rest is the squared distance

struct Nearest {
  I node[kBlended + 1]; // nearest first; the last has no say
  F squared[kBlended + 1];
};

Nearest find_nearest(const std::vector<float>& positions, int count, const Vec3& at) {
  const Ints di;
  const I number_bits = hn::Set(di, kNumberBits);
  F keys[kBlended + 1];
  for (F& key : keys) key = constant(3e38F);
  for (int n = 0; n < count; ++n) {
    const float* p = positions.data() + 4 * n;
    const Vec3 offset = sub(at, {constant(p[0]), constant(p[1]), constant(p[2])});
    const I bits = hn::BitCast(di, dot(offset, offset));
    F key = hn::BitCast(Floats(), hn::Or(hn::AndNot(number_bits, bits), hn::Set(di, n)));
    for (F& kept : keys) {
      const F nearer = hn::Min(kept, key);
      key = hn::Max(kept, key);
      kept = nearer;
    }
  }
  Nearest nearest;
  for (int k = 0; k <= kBlended; ++k) {
    nearest.node[k] = hn::And(hn::BitCast(di, keys[k]), number_bits);
    const Vec3 offset = sub(at, gather4(positions.data(), hn::ShiftLeft<2>(nearest.node[k])).v);
    nearest.squared[k] = dot(offset, offset);
  }
  return nearest;
}

struct Blend {
  Quat real, dual;
  F twice_inverse_norm;

  Vec3 moved(const Vec3& at) const {
    const Vec3 turned = add(mul_add(real.w, at, cross(real.v, at)), dual.v);
    const Vec3 shift = add(cross(real.v, turned), sub(mul(real.w, dual.v), mul(dual.w, real.v)));
    return mul_add(twice_inverse_norm, shift, at);
  }
  Vec3 rotated_back(const Vec3& v) const {
    return sub(v, mul(twice_inverse_norm, cross(real.v, sub(mul(real.w, v), cross(real.v, v)))));
  }
  Vec3 moved_back(const Vec3& at) const {
    const Vec3 shift = add(cross(real.v, dual.v), sub(mul(real.w, dual.v), mul(dual.w, real.v)));
    return rotated_back(sub(at, mul(twice_inverse_norm, shift)));
  }
};

Blend blend(const Nodes& nodes, const Nearest& nearest, bool less_the_first_without) {
  const Floats df;
  const F sharpness = constant(nodes.inverse_squared_weight_radius);
  const auto weight = [&](F squared) { return hn::Exp(df, hn::Mul(hn::Sub(nearest.squared[0], squared), sharpness)); };
  const F reach = constant(nodes.squared_influence_radius);
  const F without = less_the_first_without ? weight(hn::Min(nearest.squared[kBlended], reach)) : zero();
  Blend sum{{{zero(), zero(), zero()}, zero()}, {{zero(), zero(), zero()}, zero()}, zero()};
  Quat first{};
  for (int k = 0; k < kBlended; ++k) {
    const I at = hn::ShiftLeft<3>(nearest.node[k]);
    const Quat real = gather4(nodes.transforms.data(), at);
    const Quat dual = gather4(nodes.transforms.data() + 4, at);
    if (k == 0) first = real;
    F share = hn::Max(hn::Sub(weight(nearest.squared[k]), without), constant(k == 0 ? 1e-6F : 0.0F));
    share = hn::IfThenElse(hn::Lt(dot(real, first), zero()), hn::Neg(share), share);
    sum.real = mul_add(share, real, sum.real);
    sum.dual = mul_add(share, dual, sum.dual);
  }
  sum.twice_inverse_norm = hn::Div(constant(2), dot(sum.real, sum.real));
  return sum;
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
    return blend(nodes, find_nearest(nodes.live, nodes.count, at), false).moved_back(at);
  });
}

void exactly(const Nodes& nodes, const BruteForce::Point* world, std::size_t count, BruteForce::Point* canonical) {
  constexpr float kTolerance = 1e-4F;
  constexpr int kSteps = 12;
  for_lanes(world, count, canonical, [&](const Vec3& at) HWY_ATTR {
    const F nothing = hn::NaN(Floats());
    Vec3 place = blend(nodes, find_nearest(nodes.live, nodes.count, at), false).moved_back(at);
    Mask settled = hn::Ne(zero(), zero());
    for (int step = 0; step < kSteps; ++step) {
      const Blend here = blend(nodes, find_nearest(nodes.canonical, nodes.count, place), true);
      const Vec3 miss = sub(at, here.moved(place));
      settled = hn::Or(settled, hn::Lt(dot(miss, miss), constant(kTolerance * kTolerance)));
      if (hn::AllTrue(Floats(), settled)) break;
      place = choose(settled, place, add(place, here.rotated_back(miss)));
    }
    return choose(settled, place, {nothing, nothing, nothing});
  });
}

} // namespace kinora::bench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::bench {

HWY_EXPORT(by_live_nodes);
HWY_EXPORT(exactly);

BruteForce::BruteForce(const tracking::DeformationGraph& graph, const tracking::Warp& warp)
    : canonical_origin_(graph.nodes().front()), world_origin_(warp.node_positions().front()) {
  const auto append = [](std::vector<float>& rows, const Eigen::Vector3d& at) {
    for (const double x : {at.x(), at.y(), at.z(), 0.0}) rows.push_back(static_cast<float>(x));
  };
  nodes_.count = static_cast<int>(graph.nodes().size());
  if (nodes_.count > kMostNodes) throw Error(ErrorCode::kFailure, "the graph has too many nodes for this bench");
  for (std::size_t n = 0; n < static_cast<std::size_t>(nodes_.count); ++n) {
    append(nodes_.canonical, graph.nodes()[n] - canonical_origin_);
    append(nodes_.live, warp.node_positions()[n] - world_origin_);
    SE3 relative = warp.node_to_world()[n].to_se3();
    relative.translation() += relative.linear() * canonical_origin_ - world_origin_;
    const DualQuaternion q = DualQuaternion::from(relative);
    for (const Eigen::Quaterniond& part : {q.real, q.dual}) {
      for (int c = 0; c < 4; ++c) nodes_.transforms.push_back(static_cast<float>(part.coeffs()[c])); // x y z w
    }
  }
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
