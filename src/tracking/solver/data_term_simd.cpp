#include "tracking/solver/data_term.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tracking/solver/data_term_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

#include "core/robust_cost_simd.h"
#include "motion/skinning/skinned_points_simd.h"
#include "tracking/solver/texture_sampling_simd.h"
#include "tracking/view/visibility.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace vectors::HWY_NAMESPACE;
using namespace skinning::HWY_NAMESPACE;

/// The residuals of some points side by side.
struct Residuals {
  Vec3 position;
  Vec3 plane_normal;
  F plane_scale, texture_scales[DataTerm::kTextures];
  F plane, textures[DataTerm::kTextures];
  Vec3 gradient; ///< of the image's texture, by the point's place
};

template <bool kWithGradient>
HWY_INLINE Residuals residuals_at(const motion::PosedPoint* points, const DataTerm* terms, std::size_t count,
                                  const TextureImage& image) {
  const Floats df;
  Residuals r;
  r.position = load_rows([&](std::size_t lane) { return points[item_of(lane, count)].position.data(); }).v;
  const Quat plane = load_rows([&](std::size_t lane) { return terms[item_of(lane, count)].plane_normal.data(); });
  const Quat texture = load_rows([&](std::size_t lane) { return terms[item_of(lane, count)].expected.data(); });
  HWY_ALIGN float scales[hn::MaxLanes(df)];
  for (std::size_t lane = 0; lane < hn::Lanes(df); ++lane) scales[lane] = lane < count ? terms[lane].plane_scale : 0;
  const Mask in_range = hn::Lt(hn::Iota(df, 0), constant(static_cast<float>(count)));
  const Mask in_front = hn::And(in_range, hn::Ge(r.position.z, constant(static_cast<float>(kNearestDepth))));
  r.plane_normal = plane.v;
  r.plane_scale = hn::Load(df, scales);
  r.plane = hn::Mul(r.plane_scale, hn::Add(dot(plane.v, r.position), plane.w));
  r.texture_scales[0] = hn::IfThenElseZero(in_front, texture.v.z);
  r.texture_scales[1] = hn::IfThenElseZero(in_front, texture.w);
  r.textures[0] = r.textures[1] = r.gradient.x = r.gradient.y = r.gradient.z = zero();
  const Mask textured = hn::Gt(hn::Max(r.texture_scales[0], r.texture_scales[1]), zero());
  if (hn::AllFalse(df, textured)) return r;
  const F inverse_depth = hn::Div(constant(1), hn::IfThenElse(textured, r.position.z, constant(1)));
  const F per_x = hn::Mul(constant(image.fx), inverse_depth);
  const F per_y = hn::Mul(constant(image.fy), inverse_depth);
  const F u = hn::MulAdd(per_x, r.position.x, constant(image.cx));
  const F v = hn::MulAdd(per_y, r.position.y, constant(image.cy));
  const TextureLanes at(image, u, v);
  const F value = at.sample(0);
  r.textures[0] = hn::Mul(r.texture_scales[0], hn::Sub(value, texture.v.x));
  r.textures[1] = hn::Mul(r.texture_scales[1], hn::Sub(value, texture.v.y));
  if (kWithGradient) {
    r.gradient.x = hn::Mul(at.sample(1), per_x);
    r.gradient.y = hn::Mul(at.sample(2), per_y);
    r.gradient.z =
        hn::Neg(hn::Mul(inverse_depth, hn::MulAdd(r.gradient.x, r.position.x, hn::Mul(r.gradient.y, r.position.y))));
  }
  return r;
}

HWY_INLINE F energy_at(const Residuals& r, const HuberLanes& huber) {
  return hn::Add(huber.cost(r.plane), hn::Add(huber.cost(r.textures[0]), huber.cost(r.textures[1])));
}

struct RowLanes {
  F residual;
  Vec3 gradient;
};

HWY_INLINE RowLanes plane_row(const Residuals& r, const HuberLanes& huber) {
  const F root = hn::Sqrt(huber.weight(r.plane));
  return {hn::Mul(root, r.plane), mul(hn::Mul(root, r.plane_scale), r.plane_normal)};
}

HWY_INLINE RowLanes texture_row(const Residuals& r, const HuberLanes& huber) {
  F information = zero();
  F sum = zero();
  for (std::size_t t = 0; t < DataTerm::kTextures; ++t) {
    const F weighted = hn::Mul(huber.weight(r.textures[t]), r.texture_scales[t]);
    information = hn::MulAdd(weighted, r.texture_scales[t], information);
    sum = hn::MulAdd(weighted, r.textures[t], sum);
  }
  const Mask none = hn::Eq(information, zero());
  const F root = hn::Sqrt(information);
  const F residual = hn::Div(sum, hn::IfThenElse(none, constant(1), root));
  const Mask flat = hn::Eq(dot(r.gradient, r.gradient), zero());
  return {hn::IfThenZeroElse(hn::Or(none, flat), residual), mul(root, r.gradient)};
}

/// What a step of one node does to the transform at the points that it helps to move: NodeJacobian, in lanes.
class NodeJacobianLanes {
public:
  /// `weighted`: the node's share in the sum that `b` is of.
  HWY_INLINE NodeJacobianLanes(const NormalisedBlend& b, const DualQuat& weighted, const Vec3& position)
      : position_(position) {
    // q · conjugate of the blend
    const auto back = [](const Quat& q, const Quat& by) {
      return Quat{add(sub(mul(by.w, q.v), mul(q.w, by.v)), cross(by.v, q.v)), dot(q, by)};
    };
    const Quat real = back(weighted.real, b.real);
    const Quat first = back(weighted.dual, b.real);
    const Quat second = back(weighted.real, b.dual);
    const F shrink = hn::Neg(hn::Mul(b.dual_norm, b.inverse_norm));
    const Quat dual = mul_add(shrink, real, {add(first.v, second.v), hn::Add(first.w, second.w)});
    real_ = mul(b.inverse_norm, real);
    dual_ = mul(b.inverse_norm, dual);
  }

  HWY_INLINE void pullback(const Vec3& g, const Vec3& m, Vec3& translation, Vec3& rotation) const {
    translation = mul_add(real_.w, g, cross(real_.v, g));
    const Vec3 by_dual = mul_add(dual_.w, g, cross(dual_.v, g));
    const Vec3 by_moment = mul_add(real_.w, m, cross(real_.v, m));
    rotation = add(add(by_dual, by_moment), cross(translation, position_));
  }

private:
  Quat real_, dual_;
  Vec3 position_;
};

double add_energies(const motion::PosedPoint* points, const DataTerm* terms, std::size_t count,
                    const TextureImage& image, float threshold) {
  const HuberLanes huber(threshold);
  F sum = zero();
  for (std::size_t begin = 0; begin < count; begin += hn::Lanes(Floats())) {
    const std::size_t here = HWY_MIN(count - begin, hn::Lanes(Floats()));
    sum = hn::Add(sum, energy_at(residuals_at<false>(points + begin, terms + begin, here, image), huber));
  }
  return static_cast<double>(hn::GetLane(hn::SumOfLanes(Floats(), sum)));
}

double rows_in_lanes(const motion::PosedPoint* points, const DataTerm* terms, std::size_t count,
                     const TextureImage& image, float threshold, ResidualRows* rows) {
  const HuberLanes huber(threshold);
  F sum = zero();
  for (std::size_t begin = 0; begin < count; begin += hn::Lanes(Floats())) {
    const std::size_t here = HWY_MIN(count - begin, hn::Lanes(Floats()));
    const Residuals r = residuals_at<true>(points + begin, terms + begin, here, image);
    sum = hn::Add(sum, energy_at(r, huber));
    const RowLanes row[] = {plane_row(r, huber), texture_row(r, huber)};
    for (std::size_t i = 0; i < PointJacobians::kRows; ++i) {
      store_rows({row[i].gradient, row[i].residual}, here,
                 [&](std::size_t lane) { return rows[begin + lane][i].gradient.data(); });
    }
  }
  return static_cast<double>(hn::GetLane(hn::SumOfLanes(Floats(), sum)));
}

double jacobians_in_lanes(const motion::SkinnedPoint* skinned, const motion::NodeRows& nodes,
                          const motion::PosedPoint* points, const DataTerm* terms, std::size_t count,
                          const TextureImage& image, float threshold, PointJacobians* jacobians) {
  const Floats df;
  const HuberLanes huber(threshold);
  F sum = zero();
  for (std::size_t begin = 0; begin < count; begin += hn::Lanes(df)) {
    const std::size_t here = HWY_MIN(count - begin, hn::Lanes(df));
    const Residuals r = residuals_at<true>(points + begin, terms + begin, here, image);
    sum = hn::Add(sum, energy_at(r, huber));
    const RowLanes row[] = {plane_row(r, huber), texture_row(r, huber)};
    HWY_ALIGN float residuals[PointJacobians::kRows][hn::MaxLanes(df)];
    HWY_ALIGN float used[hn::MaxLanes(df)];
    hn::Store(row[0].residual, df, residuals[0]);
    hn::Store(row[1].residual, df, residuals[1]);
    hn::Store(hn::Add(dot(row[0].gradient, row[0].gradient), dot(row[1].gradient, row[1].gradient)), df, used);
    PointJacobians* out = jacobians + begin;
    for (std::size_t lane = 0; lane < here; ++lane) {
      out[lane].empty = used[lane] == 0;
      out[lane].residuals = {residuals[0][lane], residuals[1][lane]};
    }
    if (hn::AllTrue(df, hn::Eq(hn::Load(df, used), zero()))) continue;
    const WeightedTransforms weighted = weighted_transforms(skinned + begin, here, nodes.transforms.data());
    const NormalisedBlend blend(weighted.sum);
    const Vec3 moments[] = {cross(r.position, row[0].gradient), cross(r.position, row[1].gradient)};
    for (std::size_t k = 0; k < motion::Influence::kMax; ++k) {
      const Vec3 position = load_rows([&](std::size_t lane) {
                              const std::int32_t node = skinned[begin + item_of(lane, here)].nodes[k];
                              return nodes.positions[static_cast<std::size_t>(node)].data();
                            }).v;
      const NodeJacobianLanes part(blend, weighted.of_node[k], position);
      for (std::size_t i = 0; i < PointJacobians::kRows; ++i) {
        Vec3 t;
        Vec3 w;
        part.pullback(row[i].gradient, moments[i], t, w);
        store_rows({t, w.x}, here, [&](std::size_t lane) { return out[lane].by_node[k][i].data(); });
        store_rows({{w.y, w.z, zero()}, zero()}, here,
                   [&](std::size_t lane) { return out[lane].by_node[k][i].data() + 4; });
      }
    }
  }
  return static_cast<double>(hn::GetLane(hn::SumOfLanes(df, sum)));
}

} // namespace kinora::tracking::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::tracking {

HWY_EXPORT(add_energies);
HWY_EXPORT(rows_in_lanes);
HWY_EXPORT(jacobians_in_lanes);

TextureImage texture_image(const LayerView& view, int level) {
  const TextureLevel& texture = view.pyramid[static_cast<std::size_t>(level)];
  const Intrinsics& camera = view.intrinsics;
  return {static_cast<float>(camera.fx), static_cast<float>(camera.fy),
          static_cast<float>(camera.cx), static_cast<float>(camera.cy),
          texture.values.data(),         texture.values.width(),
          texture.values.height(),       texture.scale};
}

double data_energy(std::span<const motion::PosedPoint> points, std::span<const DataTerm> terms,
                   const TextureImage& texture, double huber) {
  return HWY_DYNAMIC_DISPATCH(add_energies)(points.data(), terms.data(), points.size(), texture,
                                            static_cast<float>(huber));
}

double evaluate_rows(std::span<const motion::PosedPoint> points, std::span<const DataTerm> terms,
                     const TextureImage& texture, double huber, std::span<ResidualRows> rows) {
  return HWY_DYNAMIC_DISPATCH(rows_in_lanes)(points.data(), terms.data(), points.size(), texture,
                                             static_cast<float>(huber), rows.data());
}

double evaluate_jacobians(std::span<const motion::SkinnedPoint> skinned, const motion::NodeRows& nodes,
                          std::span<const motion::PosedPoint> points, std::span<const DataTerm> terms,
                          const TextureImage& texture, double huber, std::span<PointJacobians> jacobians) {
  return HWY_DYNAMIC_DISPATCH(jacobians_in_lanes)(skinned.data(), nodes, points.data(), terms.data(), points.size(),
                                                  texture, static_cast<float>(huber), jacobians.data());
}

} // namespace kinora::tracking
#endif
