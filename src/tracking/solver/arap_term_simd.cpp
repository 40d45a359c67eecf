#include "tracking/solver/arap_term.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tracking/solver/arap_term_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

#include "core/robust_cost_simd.h"
#include "motion/skinning/skinning_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace vectors::HWY_NAMESPACE;
using namespace skinning::HWY_NAMESPACE;

double arap_in_lanes(const ArapEdge* edges, std::size_t count, const motion::NodeRows& nodes, float sigma,
                     float threshold, ArapResiduals* residuals) {
  const Floats df;
  const F per_sigma = constant(1 / sigma);
  const F information = constant(1 / (sigma * sigma));
  const HuberLanes huber(threshold);
  F energy = zero();
  for (std::size_t begin = 0; begin < count; begin += hn::Lanes(df)) {
    const std::size_t here = HWY_MIN(count - begin, hn::Lanes(df));
    const ArapEdge* some = edges + begin;
    const auto node_of = [&](std::size_t lane, std::int32_t ArapEdge::*end) {
      return static_cast<std::size_t>(some[item_of(lane, here)].*end);
    };
    const auto position = [&](std::int32_t ArapEdge::*end) {
      return load_rows([&](std::size_t lane) { return nodes.positions[node_of(lane, end)].data(); }).v;
    };
    const auto rotation = [&](std::int32_t ArapEdge::*end) {
      return load_rows([&](std::size_t lane) { return nodes.transforms[node_of(lane, end)].real.data(); });
    };
    const Vec3 along = load_rows([&](std::size_t lane) { return some[item_of(lane, here)].along.data(); }).v;
    const Vec3 ab = sub(position(&ArapEdge::b), position(&ArapEdge::a));
    const Vec3 there = sub(rotated(rotation(&ArapEdge::a), along), ab);
    const Vec3 back = sub(ab, rotated(rotation(&ArapEdge::b), along));
    const Mask in_range = hn::Lt(hn::Iota(df, 0), constant(static_cast<float>(here)));
    for (const std::size_t way : {std::size_t{0}, std::size_t{1}}) {
      const Vec3& residual = way == 0 ? there : back;
      const F size = hn::Mul(per_sigma, hn::Sqrt(dot(residual, residual)));
      energy = hn::Add(energy, hn::IfThenElseZero(in_range, huber.cost(size)));
      if (residuals == nullptr) continue;
      const F weight = hn::Mul(information, huber.weight(size));
      store_rows({residual, weight}, here, [&](std::size_t lane) { return residuals[begin + lane][way].value.data(); });
    }
  }
  return static_cast<double>(hn::GetLane(hn::SumOfLanes(df, energy)));
}

} // namespace kinora::tracking::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::tracking {

HWY_EXPORT(arap_in_lanes);

std::vector<ArapEdge> rows_of(std::span<const GraphEdge> edges, std::span<const Eigen::Vector3d> nodes) {
  std::vector<ArapEdge> rows;
  rows.reserve(edges.size());
  for (const GraphEdge& edge : edges) {
    const Eigen::Vector3f along =
        (nodes[static_cast<std::size_t>(edge.b)] - nodes[static_cast<std::size_t>(edge.a)]).cast<float>();
    rows.push_back({{along.x(), along.y(), along.z()}, 0, edge.a, edge.b});
  }
  return rows;
}

double arap_energy(std::span<const ArapEdge> edges, const motion::NodeRows& nodes, double sigma, double huber,
                   std::span<ArapResiduals> residuals) {
  return HWY_DYNAMIC_DISPATCH(arap_in_lanes)(edges.data(), edges.size(), nodes, static_cast<float>(sigma),
                                             static_cast<float>(huber), residuals.empty() ? nullptr : residuals.data());
}

} // namespace kinora::tracking
#endif
