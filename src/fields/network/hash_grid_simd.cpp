#include "fields/network/hash_grid.h"

#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/network/hash_grid_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

#include "fields/network/row_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kF = FieldConfig::kFeatures;
constexpr int kRowShift = std::countr_zero(static_cast<unsigned>(kF));
constexpr std::size_t kBlock = 16; // points whose corners are found together

/// The eight corners of a block of points: where the entry's row begins within the level, and the trilinear weight.
struct Corners {
  HWY_ALIGN std::uint32_t row[8][kBlock];
  HWY_ALIGN float weight[8][kBlock];
};

template <class DF> struct Axis {
  hn::Vec<hn::RebindToSigned<DF>> low;
  hn::Vec<DF> fraction;
};

template <class DF> HWY_INLINE Axis<DF> locate(DF df, const float* coordinate, std::int32_t resolution) {
  const hn::RebindToSigned<DF> di;
  const auto scaled = hn::Mul(hn::Min(hn::Max(hn::LoadU(df, coordinate), hn::Zero(df)), hn::Set(df, 1.0F)),
                              hn::Set(df, static_cast<float>(resolution)));
  const auto low = hn::Min(hn::ConvertTo(di, scaled), hn::Set(di, resolution - 1));
  return {low, hn::Sub(scaled, hn::ConvertTo(df, low))};
}

/// Asks for the corners' memory, too: `rows` begins with the level's first entry. (GCC leaves out calls of a function
/// whose only effect is a prefetch.)
HWY_INLINE void find_corners(const GridLevel& level, const float* x, const float* y, const float* z, const float* rows,
                             Corners& corners) {
  const hn::CappedTag<float, kBlock> df;
  const hn::RebindToSigned<decltype(df)> di;
  const hn::RebindToUnsigned<decltype(df)> du;
  const auto one_f = hn::Set(df, 1.0F);
  const auto one = hn::Set(di, 1);
  const std::int32_t side = level.resolution + 1;
  const auto factor_y = hn::Set(di, level.hashed ? static_cast<std::int32_t>(2654435761U) : side);
  const auto factor_z = hn::Set(di, level.hashed ? static_cast<std::int32_t>(805459861U) : side * side);
  const auto mask = hn::Set(di, static_cast<std::int32_t>(level.size - 1));
  for (std::size_t i = 0; i < kBlock; i += hn::Lanes(df)) {
    const auto ax = locate(df, x + i, level.resolution);
    const auto ay = locate(df, y + i, level.resolution);
    const auto az = locate(df, z + i, level.resolution);
    const decltype(one) xs[2] = {ax.low, hn::Add(ax.low, one)};
    const auto y0 = hn::Mul(ay.low, factor_y);
    const auto z0 = hn::Mul(az.low, factor_z);
    const decltype(one) ys[2] = {y0, hn::Add(y0, factor_y)};
    const decltype(one) zs[2] = {z0, hn::Add(z0, factor_z)};
    const decltype(one_f) wx[2] = {hn::Sub(one_f, ax.fraction), ax.fraction};
    const decltype(one_f) wy[2] = {hn::Sub(one_f, ay.fraction), ay.fraction};
    const decltype(one_f) wz[2] = {hn::Sub(one_f, az.fraction), az.fraction};
    for (int c = 0; c < 8; ++c) {
      const int dx = c & 1, dy = (c >> 1) & 1, dz = c >> 2;
      const auto entry = level.hashed ? hn::And(hn::Xor(hn::Xor(xs[dx], ys[dy]), zs[dz]), mask)
                                      : hn::Add(hn::Add(xs[dx], ys[dy]), zs[dz]);
      hn::Store(hn::BitCast(du, hn::ShiftLeft<kRowShift>(entry)), du, corners.row[c] + i);
      hn::Store(hn::Mul(hn::Mul(wx[dx], wy[dy]), wz[dz]), df, corners.weight[c] + i);
    }
  }
  for (const auto& begins : corners.row) {
    for (const std::uint32_t begin : begins) __builtin_prefetch(rows + begin);
  }
}

/// A block of coordinates, repeated zero beyond the end, so that whole vectors can be loaded.
struct Block {
  HWY_ALIGN float x[kBlock] = {}, y[kBlock] = {}, z[kBlock] = {};
  std::size_t count;

  Block(const Points& points, std::size_t begin) : count(std::min(kBlock, points.count - begin)) {
    for (std::size_t i = 0; i < count; ++i) {
      x[i] = points.x[begin + i];
      y[i] = points.y[begin + i];
      z[i] = points.z[begin + i];
    }
  }
};

/// out = the block's features of one level.
HWY_INLINE void interpolate(const Corners& corners, const float* rows, std::size_t count, std::size_t width,
                            float* out) {
  using R = Row<kF>;
  const R::Tag d;
  for (std::size_t i = 0; i < count; ++i, out += width) {
    for (int v = 0; v < R::kVectors; ++v) {
      const auto weighted = [&](int c) HWY_ATTR {
        const float* row = rows + corners.row[c][i] + v * R::kLanes;
        return hn::Mul(hn::Set(d, corners.weight[c][i]), hn::LoadU(d, row));
      };
      const auto add = [&](R::Vector sum, int c) HWY_ATTR {
        const float* row = rows + corners.row[c][i] + v * R::kLanes;
        return hn::MulAdd(hn::Set(d, corners.weight[c][i]), hn::LoadU(d, row), sum);
      };
      // Two chains: one alone would wait for itself.
      const auto front = add(add(add(weighted(0), 1), 2), 3);
      const auto back = add(add(add(weighted(4), 5), 6), 7);
      hn::StoreU(hn::Add(front, back), d, out + v * R::kLanes);
    }
  }
}

void encode(std::span<const GridLevel> levels, const float* table, const Points& points, float* encodings) {
  const std::size_t width = levels.size() * kF;
  const auto rows_of = [&](std::size_t l) { return table + static_cast<std::size_t>(levels[l].offset) * kF; };
  Corners corners[2]; // those of the next level are found, and their memory is on its way, while one is read
  for (std::size_t begin = 0; begin < points.count; begin += kBlock) {
    const Block block(points, begin);
    find_corners(levels[0], block.x, block.y, block.z, rows_of(0), corners[0]);
    for (std::size_t l = 0; l < levels.size(); ++l) {
      if (l + 1 < levels.size()) {
        find_corners(levels[l + 1], block.x, block.y, block.z, rows_of(l + 1), corners[(l + 1) % 2]);
      }
      interpolate(corners[l % 2], rows_of(l), block.count, width, encodings + begin * width + l * kF);
    }
  }
}

/// Whether points i and k of a block lie in one cell. The other four corners follow from these: entries are sums, or
/// exclusive ors, of a term for each axis.
HWY_INLINE bool in_one_cell(const Corners& corners, std::size_t i, std::size_t k) {
  return corners.row[0][i] == corners.row[0][k] && corners.row[1][i] == corners.row[1][k] &&
         corners.row[2][i] == corners.row[2][k] && corners.row[4][i] == corners.row[4][k];
}

void scatter_level(const GridLevel& level, const Points& points, const float* feature_gradients, std::size_t stride,
                   float* table_gradient) {
  using R = Row<kF>;
  const R::Tag d;
  Corners both[2];
  const auto find = [&](std::size_t begin) HWY_ATTR {
    const Block block(points, begin);
    find_corners(level, block.x, block.y, block.z, table_gradient, both[begin / kBlock % 2]);
  };
  if (points.count > 0) find(0);
  for (std::size_t begin = 0; begin < points.count; begin += kBlock) {
    if (begin + kBlock < points.count) find(begin + kBlock);
    const Corners& corners = both[begin / kBlock % 2];
    const std::size_t count = std::min(kBlock, points.count - begin);
    for (std::size_t first = 0, end = 0; first < count; first = end) {
      for (end = first + 1; end < count && in_one_cell(corners, first, end);) ++end;
      for (int v = 0; v < R::kVectors; ++v) {
        const float* gradients = feature_gradients + begin * stride + v * R::kLanes;
        R::Vector sums[8];
        const auto g = hn::LoadU(d, gradients + first * stride);
        for (int c = 0; c < 8; ++c) sums[c] = hn::Mul(hn::Set(d, corners.weight[c][first]), g);
        for (std::size_t i = first + 1; i < end; ++i) {
          const auto next = hn::LoadU(d, gradients + i * stride);
          for (int c = 0; c < 8; ++c) sums[c] = hn::MulAdd(hn::Set(d, corners.weight[c][i]), next, sums[c]);
        }
        for (int c = 0; c < 8; ++c) { // one after the other: two corners may share an entry
          float* row = table_gradient + corners.row[c][first] + v * R::kLanes;
          hn::StoreU(hn::Add(hn::LoadU(d, row), sums[c]), d, row);
        }
      }
    }
  }
}

} // namespace kinora::fields::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::fields::kernels {

HWY_EXPORT(encode);
HWY_EXPORT(scatter_level);

void encode(std::span<const GridLevel> levels, const float* table, const Points& points, float* encodings) {
  HWY_DYNAMIC_DISPATCH(encode)(levels, table, points, encodings);
}
void scatter_level(const GridLevel& level, const Points& points, const float* feature_gradients, std::size_t stride,
                   float* table_gradient) {
  HWY_DYNAMIC_DISPATCH(scatter_level)(level, points, feature_gradients, stride, table_gradient);
}

} // namespace kinora::fields::kernels
#endif
