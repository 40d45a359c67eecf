#include <bit>

#include "fields/rendering/rasterizer.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/rendering/rasterizer_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

#include "core/vectors_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace vectors::HWY_NAMESPACE;

constexpr float kBehind = 1e-3F; // metres: nearer corners have no place in the picture

// Share of a barycentric coordinate by which a ray may pass outside of a triangle, so that rounding leaves no gap
// between neighbours.
constexpr float kSlack = 1e-4F;

HWY_INLINE std::uint32_t bits_of(Mask mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(Floats(), mask, bytes);
  return bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8;
}

/// A corner in the camera's frame and its place in the picture.
struct Corner {
  Vec3 at;
  F u, v;
  Mask behind;
};

/// Triangles of as many faces as there are lanes: fields of ProxyTriangle.
struct Triangles {
  HWY_ALIGN float rows[9][kMaxLanes];
  HWY_ALIGN std::int32_t bounds[4][kMaxLanes];
  std::uint32_t seen = 0; ///< bits
};

HWY_INLINE void set_up(const Corner& a, const Corner& b, const Corner& c, const Intrinsics& intrinsics,
                       Triangles& triangles) {
  const Floats df;
  const Ints di;
  // b × c = b × (c − b): small triangles far away lose no digits, and leave no gaps between them.
  const Vec3 ab = sub(b.at, a.at);
  const Vec3 ca = sub(a.at, c.at);
  const Vec3 edges[3] = {cross(b.at, sub(c.at, b.at)), cross(c.at, ca), cross(a.at, ab)};
  const F determinant = dot(a.at, cross(ca, ab));
  const F right = constant(static_cast<float>(intrinsics.width - 1));
  const F bottom = constant(static_cast<float>(intrinsics.height - 1));
  const Mask any_behind = hn::Or(a.behind, hn::Or(b.behind, c.behind));
  const Mask all_behind = hn::And(a.behind, hn::And(b.behind, c.behind));
  const auto lowest = [&](F p, F q, F r) HWY_ATTR {
    const F low = hn::Ceil(hn::Sub(hn::Min(p, hn::Min(q, r)), constant(0.01F)));
    return hn::Max(zero(), hn::IfThenZeroElse(any_behind, low));
  };
  const auto highest = [&](F p, F q, F r, F limit) HWY_ATTR {
    const F high = hn::Floor(hn::Add(hn::Max(p, hn::Max(q, r)), constant(0.01F)));
    return hn::Min(limit, hn::IfThenElse(any_behind, limit, high));
  };
  const F bounds[4] = {lowest(a.u, b.u, c.u), highest(a.u, b.u, c.u, right), lowest(a.v, b.v, c.v),
                       highest(a.v, b.v, c.v, bottom)};
  Mask seen = hn::Lt(determinant, zero()); // from outside, and finite
  seen = hn::And(seen, hn::And(hn::Le(bounds[0], bounds[1]), hn::Le(bounds[2], bounds[3])));
  seen = hn::AndNot(all_behind, seen);
  triangles.seen = bits_of(seen);
  if (triangles.seen == 0) return;
  const F scale = hn::Div(constant(1), determinant);
  for (std::size_t r = 0; r < 3; ++r) {
    hn::Store(hn::Mul(scale, edges[r].x), df, triangles.rows[3 * r]);
    hn::Store(hn::Mul(scale, edges[r].y), df, triangles.rows[3 * r + 1]);
    hn::Store(hn::Mul(scale, edges[r].z), df, triangles.rows[3 * r + 2]);
  }
  for (std::size_t k = 0; k < 4; ++k) {
    hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(seen, bounds[k])), di, triangles.bounds[k]);
  }
}

/// Of faces[0] … faces[count − 1] those with an odd or even number.
HWY_INLINE void append(const Triangles& triangles, std::span<const ProxyFace> faces, std::size_t second,
                       std::uint8_t layer, std::vector<ProxyTriangle>& out) {
  for (std::uint32_t seen = triangles.seen; seen != 0; seen &= seen - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(seen));
    if (i >= faces.size()) return;
    ProxyTriangle& triangle = out.emplace_back();
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t k = 0; k < 3; ++k) triangle.rows[r][k] = triangles.rows[3 * r + k][i];
    }
    triangle.corners = {faces[i][0], faces[i][second], faces[i][second + 1]};
    for (std::size_t k = 0; k < 4; ++k) triangle.bounds[k] = static_cast<std::int16_t>(triangles.bounds[k][i]);
    triangle.layer = layer;
  }
}

void add_front(const Intrinsics& intrinsics, const Eigen::Vector3f* corners, std::span<const ProxyFace> faces,
               std::uint8_t layer, std::vector<ProxyTriangle>& out) {
  const Floats df;
  const Ints di;
  const std::size_t lanes = hn::Lanes(df);
  HWY_ALIGN std::int32_t index[4][kMaxLanes] = {};
  Triangles triangles{};
  for (std::size_t begin = 0; begin < faces.size(); begin += lanes) {
    const auto some = faces.subspan(begin, HWY_MIN(lanes, faces.size() - begin));
    for (std::size_t i = 0; i < some.size(); ++i) {
      for (std::size_t k = 0; k < 4; ++k) index[k][i] = static_cast<std::int32_t>(3 * some[i][k]);
    }
    Corner at[4];
    for (std::size_t k = 0; k < 4; ++k) {
      const auto first = hn::Load(di, index[k]);
      Corner& corner = at[k];
      corner.at = gather3(corners->data(), first);
      corner.behind = hn::Lt(corner.at.z, constant(kBehind));
      const F inverse = hn::Div(constant(1), corner.at.z);
      corner.u = hn::MulAdd(hn::Mul(constant(static_cast<float>(intrinsics.fx)), corner.at.x), inverse,
                            constant(static_cast<float>(intrinsics.cx)));
      corner.v = hn::MulAdd(hn::Mul(constant(static_cast<float>(intrinsics.fy)), corner.at.y), inverse,
                            constant(static_cast<float>(intrinsics.cy)));
    }
    for (const std::size_t second : {std::size_t{1}, std::size_t{2}}) {
      set_up(at[0], at[second], at[second + 1], intrinsics, triangles);
      append(triangles, some, second, layer, out);
    }
  }
}

void rasterize(const ProxyTriangle& triangle, std::uint32_t index, const TileRays& rays, Entries& entries) {
  constexpr int kTile = TriangleBins::kTile;
  const Floats df;
  const auto& bounds = triangle.bounds;
  const int first_column = HWY_MAX(bounds[0] - rays.left, 0);
  const int last_column = HWY_MIN(bounds[1] - rays.left, kTile - 1);
  const int first_row = HWY_MAX(bounds[2] - rays.top, 0);
  const int last_row = HWY_MIN(bounds[3] - rays.top, kTile - 1);
  const auto& m = triangle.rows;
  const auto lanes = static_cast<int>(hn::Lanes(df));
  HWY_ALIGN float depths[kMaxLanes];
  for (int left = first_column / lanes * lanes; left <= last_column; left += lanes) {
    const std::uint32_t column_mask = (2U << (last_column - left)) - (1U << HWY_MAX(first_column - left, 0));
    const F x = hn::MulAdd(hn::Iota(df, static_cast<float>(left)), constant(rays.dx), constant(rays.x));
    const F along[3] = {hn::Mul(constant(m[0][0]), x), hn::Mul(constant(m[1][0]), x), hn::Mul(constant(m[2][0]), x)};
    for (int row = first_row; row <= last_row; ++row) {
      const float y = rays.y + static_cast<float>(row) * rays.dy;
      const F e0 = hn::Add(along[0], constant(m[0][1] * y + m[0][2]));
      const F e1 = hn::Add(along[1], constant(m[1][1] * y + m[1][2]));
      const F e2 = hn::Add(along[2], constant(m[2][1] * y + m[2][2]));
      const F inverse_depth = hn::Add(e0, hn::Add(e1, e2));
      const F min_weight = hn::Mul(constant(-kSlack), inverse_depth);
      const Mask inside = hn::And(hn::Ge(hn::Min(e0, hn::Min(e1, e2)), min_weight), hn::Gt(inverse_depth, zero()));
      std::uint32_t bits = bits_of(inside) & column_mask;
      if (bits == 0) continue;
      hn::Store(hn::Div(constant(1), inverse_depth), df, depths);
      const int begin = row * kTile + left;
      for (; bits != 0; bits &= bits - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(bits));
        entries.insert(static_cast<std::size_t>(begin) + i, {depths[i], index});
      }
    }
  }
}

} // namespace kinora::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::fields {

HWY_EXPORT(add_front);
HWY_EXPORT(rasterize);

void add_front(const Intrinsics& intrinsics, const Eigen::Vector3f* corners, std::span<const ProxyFace> faces,
               std::uint8_t layer, std::vector<ProxyTriangle>& out) {
  HWY_DYNAMIC_DISPATCH(add_front)(intrinsics, corners, faces, layer, out);
}

void rasterize(const ProxyTriangle& triangle, std::uint32_t index, const TileRays& rays, Entries& entries) {
  HWY_DYNAMIC_DISPATCH(rasterize)(triangle, index, rays, entries);
}

} // namespace kinora::fields
#endif
