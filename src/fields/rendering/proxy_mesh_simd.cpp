#include "fields/rendering/proxy_mesh_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/rendering/proxy_mesh_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

#include "motion/skinning/skinning_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::kernels::HWY_NAMESPACE {
using namespace skinning::HWY_NAMESPACE;

static_assert(kMaxLanes <= kPadding);

HWY_INLINE Vec3 load3(const Eigen::Vector3f* points) {
  Vec3 v;
  hn::LoadInterleaved3(Floats(), points->data(), v.x, v.y, v.z);
  return v;
}
HWY_INLINE void store3(const Vec3& v, Eigen::Vector3f* points) {
  hn::StoreInterleaved3(v.x, v.y, v.z, Floats(), points->data());
}

void skin(const Influences& influences, const TransformRow* transforms, const Eigen::Vector3f* canonical, float scale,
          std::size_t begin, std::size_t end, SkinnedPoints& skinned) {
  const Floats df;
  const Ints di;
  for (std::size_t i = begin; i < end; i += hn::Lanes(df)) {
    const Blend blend(weighted_sum(
        [&](std::size_t k) HWY_ATTR { return hn::LoadU(df, influences.weights[k].data() + i); },
        [&](std::size_t k)
            HWY_ATTR { return gather_transforms(transforms, hn::LoadU(di, influences.nodes[k].data() + i)); }));
    store3(blend.apply(mul(constant(scale), load3(canonical + i))), skinned.world.data() + i);
    const Quat rotation = blend.rotation();
    hn::StoreInterleaved4(rotation.v.x, rotation.v.y, rotation.v.z, rotation.w, df, skinned.rotation[i].data());
  }
}

void project(const Viewpoint& viewpoint, const SkinnedPoints& skinned, std::size_t begin, std::size_t end,
             Eigen::Vector3f* corners, Eigen::Vector3f* view_vectors) {
  const Floats df;
  const Eigen::Matrix3f& t = viewpoint.rotation;
  const auto row = [&t](const Vec3& p, int r) HWY_ATTR {
    return dot({constant(t(r, 0)), constant(t(r, 1)), constant(t(r, 2))}, p);
  };
  const Eigen::Vector3f& c = viewpoint.centre;
  for (std::size_t i = begin; i < end; i += hn::Lanes(df)) {
    const Vec3 world = load3(skinned.world.data() + i);
    const Vec3 from_camera{hn::Sub(world.x, constant(c.x())), hn::Sub(world.y, constant(c.y())),
                           hn::Sub(world.z, constant(c.z()))};
    store3({row(from_camera, 0), row(from_camera, 1), row(from_camera, 2)}, corners + i);
    Quat q;
    hn::LoadInterleaved4(df, skinned.rotation[i].data(), q.v.x, q.v.y, q.v.z, q.w);
    store3(mul(constant(viewpoint.per_metre), rotated(inverse(q), from_camera)), view_vectors + i);
  }
}

/// a + s · (b − a)
HWY_INLINE Vec3 between(const Vec3& a, const Vec3& b, F s) { return mul_add(s, sub(b, a), a); }

/// Trilinear among the corners of a cell.
struct LocalMotion {
  Vec3 value;      ///< camera's frame, metres
  Vec3 columns[3]; ///< of the derivative, metres per cell
};

HWY_INLINE LocalMotion motion_in(const CellMotion& motion, I cell, const F (&f)[3]) {
  const Ints di;
  const I first_split = hn::GatherIndex(di, motion.split_corners, cell);
  const I first = hn::Mul(cell, hn::Set(di, motion.cell_stride));
  const auto is_split = hn::Gt(first_split, hn::Set(di, -1));
  Vec3 corners[8];
  for (int c = 0; c < 8; ++c) {
    const I shared = hn::GatherIndex(di, motion.cells + c, first);
    const I number = hn::IfThenElse(is_split, hn::Add(first_split, hn::Set(di, c)), shared);
    const I at = hn::Add(hn::Add(number, number), number);
    corners[c] = gather3(motion.corners->data(), at);
  }
  // Along x, then y, then z.
  Vec3 rows[4];
  Vec3 derivatives[4];
  for (int r = 0; r < 4; ++r) {
    derivatives[r] = sub(corners[2 * r + 1], corners[2 * r]);
    rows[r] = mul_add(f[0], derivatives[r], corners[2 * r]);
  }
  const Vec3 low = between(rows[0], rows[1], f[1]);
  const Vec3 high = between(rows[2], rows[3], f[1]);
  return {between(low, high, f[2]),
          {between(between(derivatives[0], derivatives[1], f[1]), between(derivatives[2], derivatives[3], f[1]), f[2]),
           between(sub(rows[1], rows[0]), sub(rows[3], rows[2]), f[2]), sub(high, low)}};
}

void refine(const CellMotion& motion, std::size_t n, const PointLanes& points, PointLanes& positions) {
  constexpr int kSteps = 2;
  constexpr int kSide = 4;           // lattice steps of a cell
  constexpr float kConverged = 0.1F; // of a lattice step: another iteration would find nothing
  const Floats df;
  const Ints di;
  const F limit = constant(static_cast<float>(2 * motion.bricks_per_side)); // cells
  const I per_side = hn::Set(di, motion.bricks_per_side);
  const auto bit = [&](I value, int shift)
                       HWY_ATTR { return hn::Mul(hn::And(value, hn::Set(di, 1)), hn::Set(di, 1 << shift)); };
  for (std::size_t i = 0; i < n; i += hn::Lanes(df)) {
    F at[3];
    for (std::size_t a = 0; a < 3; ++a) {
      at[a] = hn::Mul(hn::LoadU(df, positions.axes[a].data() + i), constant(1.0F / kSide)); // cells
    }
    const Vec3 target{hn::LoadU(df, points.axes[0].data() + i), hn::LoadU(df, points.axes[1].data() + i),
                      hn::LoadU(df, points.axes[2].data() + i)};
    auto active = hn::Lt(hn::Iota(df, 0.0F), constant(static_cast<float>(HWY_MIN(n - i, kPadding))));
    for (int step = 0; step < kSteps; ++step) {
      I low[3];
      F fraction[3];
      for (int a = 0; a < 3; ++a) {
        active = hn::And(active, hn::And(hn::Ge(at[a], zero()), hn::Lt(at[a], limit)));
      }
      for (int a = 0; a < 3; ++a) {
        const F inside = hn::IfThenElseZero(active, at[a]);
        low[a] = hn::ConvertTo(di, inside);
        fraction[a] = hn::Sub(inside, hn::ConvertTo(df, low[a]));
      }
      const I row = hn::Add(hn::Mul(hn::ShiftRight<1>(low[2]), per_side), hn::ShiftRight<1>(low[1]));
      const I brick_index = hn::Add(hn::Mul(row, per_side), hn::ShiftRight<1>(low[0]));
      const I brick = hn::GatherIndex(di, motion.bricks, brick_index);
      active = hn::And(active, hn::RebindMask(df, hn::Gt(brick, hn::Set(di, -1))));
      const I octant = hn::Add(hn::Add(bit(low[0], 0), bit(low[1], 1)), bit(low[2], 2));
      const I entry = hn::Add(hn::ShiftLeft<3>(hn::Max(brick, hn::Zero(di))), octant);
      const I cell = hn::GatherIndex(di, motion.cells_of_brick, entry);
      active = hn::And(active, hn::RebindMask(df, hn::Gt(cell, hn::Set(di, -1))));
      if (hn::AllFalse(df, active)) break;
      const LocalMotion local = motion_in(motion, hn::Max(cell, hn::Zero(di)), fraction);
      const Vec3 residual = sub(target, local.value);
      const Vec3 c0 = cross(local.columns[1], local.columns[2]);
      const Vec3 c1 = cross(local.columns[2], local.columns[0]);
      const Vec3 c2 = cross(local.columns[0], local.columns[1]);
      const F inverse_volume = hn::Div(constant(1), dot(local.columns[0], c0));
      const Vec3 by = mul(inverse_volume, Vec3{dot(c0, residual), dot(c1, residual), dot(c2, residual)}); // cells
      const F squared = dot(by, by);
      active = hn::And(active, hn::Lt(squared, constant(1)));
      at[0] = hn::IfThenElse(active, hn::Add(at[0], by.x), at[0]);
      at[1] = hn::IfThenElse(active, hn::Add(at[1], by.y), at[1]);
      at[2] = hn::IfThenElse(active, hn::Add(at[2], by.z), at[2]);
      active = hn::And(active, hn::Ge(squared, constant(kConverged * kConverged / (kSide * kSide))));
    }
    for (std::size_t a = 0; a < 3; ++a) {
      hn::StoreU(hn::Mul(at[a], constant(kSide)), df, positions.axes[a].data() + i);
    }
  }
}

} // namespace kinora::fields::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::fields::kernels {

HWY_EXPORT(skin);
HWY_EXPORT(project);
HWY_EXPORT(refine);

Influences::Influences(std::size_t n) : count(n) {
  for (auto& values : nodes) values.assign(n + kPadding, 0);
  for (auto& values : weights) values.assign(n + kPadding, 0);
}

void Influences::set(std::size_t point, const motion::Influence& influence) {
  for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
    nodes[k][point] = influence.nodes[k];
    weights[k][point] = static_cast<float>(influence.weights[k]);
  }
}

void skin(const Influences& influences, const motion::TransformRow* transforms, const Eigen::Vector3f* canonical,
          float scale, std::size_t begin, std::size_t end, SkinnedPoints& skinned) {
  HWY_DYNAMIC_DISPATCH(skin)(influences, transforms, canonical, scale, begin, end, skinned);
}

void project(const Viewpoint& viewpoint, const SkinnedPoints& skinned, std::size_t begin, std::size_t end,
             Eigen::Vector3f* corners, Eigen::Vector3f* view_vectors) {
  HWY_DYNAMIC_DISPATCH(project)(viewpoint, skinned, begin, end, corners, view_vectors);
}

void refine(const CellMotion& motion, std::size_t n, const PointLanes& points, PointLanes& positions) {
  HWY_DYNAMIC_DISPATCH(refine)(motion, n, points, positions);
}

} // namespace kinora::fields::kernels
#endif
