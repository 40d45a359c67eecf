#include "fields/kernels.h"

#include <bit>

#include "fields/ray_batch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/kernels_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>
// after highway.h
#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kF = FieldConfig::kFeatures;
constexpr int kRowShift = std::countr_zero(static_cast<unsigned>(kF));
constexpr std::size_t kBlock = 16; // points whose corners are found together

/// A row of kWidth floats held in as many vectors as the instruction set needs.
template <int kWidth> struct Row {
  using Tag = hn::CappedTag<float, kWidth>;
  using Vector = hn::Vec<Tag>;
  static constexpr int kLanes = static_cast<int>(hn::MaxLanes(Tag()));
  static constexpr int kVectors = kWidth / kLanes;
};

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

void densities(const float* geometry, const float* lengths, std::size_t n, float* density, float* passing) {
  const hn::CappedTag<float, kBlock> d;
  HWY_ALIGN float raw[kBlock] = {};
  HWY_ALIGN float length[kBlock] = {};
  HWY_ALIGN float sigma[kBlock];
  HWY_ALIGN float pass[kBlock];
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t count = std::min(kBlock, n - begin);
    for (std::size_t i = 0; i < count; ++i) {
      raw[i] = geometry[(begin + i) * FieldConfig::kGeometry];
      length[i] = lengths[begin + i];
    }
    for (std::size_t i = 0; i < kBlock; i += hn::Lanes(d)) {
      const auto s = hn::Exp(d, hn::Min(hn::Load(d, raw + i), hn::Set(d, kMaxRawDensity)));
      hn::Store(s, d, sigma + i);
      hn::Store(hn::Exp(d, hn::Neg(hn::Mul(s, hn::Load(d, length + i)))), d, pass + i);
    }
    for (std::size_t i = 0; i < count; ++i) {
      density[begin + i] = sigma[i];
      passing[begin + i] = pass[i];
    }
  }
}

/// kRows rows of `in` times one block of 16 columns of the weights.
template <int kRows>
HWY_INLINE void dense_tile(const float* in, int inputs, const float* weights, int outputs, bool relu, float* out) {
  using R = Row<16>;
  const R::Tag d;
  R::Vector sum[kRows][R::kVectors];
  for (int r = 0; r < kRows; ++r) {
    for (int v = 0; v < R::kVectors; ++v) sum[r][v] = hn::Zero(d);
  }
  for (int i = 0; i < inputs; ++i) {
    R::Vector w[R::kVectors];
    for (int v = 0; v < R::kVectors; ++v) w[v] = hn::LoadU(d, weights + i * outputs + v * R::kLanes);
    for (int r = 0; r < kRows; ++r) {
      const auto x = hn::Set(d, in[r * inputs + i]);
      for (int v = 0; v < R::kVectors; ++v) sum[r][v] = hn::MulAdd(x, w[v], sum[r][v]);
    }
  }
  for (int r = 0; r < kRows; ++r) {
    for (int v = 0; v < R::kVectors; ++v) {
      const auto value = relu ? hn::Max(sum[r][v], hn::Zero(d)) : sum[r][v];
      hn::StoreU(value, d, out + r * outputs + v * R::kLanes);
    }
  }
}

/// Rows per tile such that the sums stay in registers.
constexpr int kTileRows = Row<16>::kVectors >= 8 ? 1 : 8 / Row<16>::kVectors;

void dense(const float* in, std::size_t n, int inputs, const float* weights, int outputs, bool relu, float* out) {
  const std::size_t stride_in = static_cast<std::size_t>(inputs);
  const std::size_t stride_out = static_cast<std::size_t>(outputs);
  for (int column = 0; column < outputs; column += 16) {
    std::size_t row = 0;
    for (; row + kTileRows <= n; row += kTileRows) {
      dense_tile<kTileRows>(in + row * stride_in, inputs, weights + column, outputs, relu,
                            out + row * stride_out + column);
    }
    for (; row < n; ++row) {
      dense_tile<1>(in + row * stride_in, inputs, weights + column, outputs, relu, out + row * stride_out + column);
    }
  }
}

void accumulate_weight_gradient(const float* in, const float* out_gradient, std::size_t n, int inputs, int outputs,
                                float* gradient) {
  using R = Row<16>;
  const R::Tag d;
  for (int column = 0; column < outputs; column += 16) {
    for (int first = 0; first < inputs; first += kTileRows) {
      R::Vector sum[kTileRows][R::kVectors];
      float* target = gradient + first * outputs + column;
      for (int r = 0; r < kTileRows; ++r) {
        for (int v = 0; v < R::kVectors; ++v) sum[r][v] = hn::LoadU(d, target + r * outputs + v * R::kLanes);
      }
      for (std::size_t k = 0; k < n; ++k) {
        const float* x = in + k * static_cast<std::size_t>(inputs) + first;
        const float* g = out_gradient + k * static_cast<std::size_t>(outputs) + column;
        R::Vector gv[R::kVectors];
        for (int v = 0; v < R::kVectors; ++v) gv[v] = hn::LoadU(d, g + v * R::kLanes);
        for (int r = 0; r < kTileRows; ++r) {
          const auto xr = hn::Set(d, x[r]);
          for (int v = 0; v < R::kVectors; ++v) sum[r][v] = hn::MulAdd(xr, gv[v], sum[r][v]);
        }
      }
      for (int r = 0; r < kTileRows; ++r) {
        for (int v = 0; v < R::kVectors; ++v) hn::StoreU(sum[r][v], d, target + r * outputs + v * R::kLanes);
      }
    }
  }
}

void relu_backward(const float* activated, std::size_t count, float* gradient) {
  const hn::CappedTag<float, 16> d;
  std::size_t i = 0;
  for (; i + hn::Lanes(d) <= count; i += hn::Lanes(d)) {
    const auto positive = hn::Gt(hn::LoadU(d, activated + i), hn::Zero(d));
    hn::StoreU(hn::IfThenElseZero(positive, hn::LoadU(d, gradient + i)), d, gradient + i);
  }
  for (; i < count; ++i) {
    if (!(activated[i] > 0)) gradient[i] = 0;
  }
}

std::size_t rows_above(const float* rows, std::size_t n, float limit, std::uint32_t* numbers) {
  using R = Row<FieldConfig::kGeometry>;
  const R::Tag d;
  std::size_t count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    bool below = true;
    for (int v = 0; v < R::kVectors; ++v) {
      const auto values = hn::LoadU(d, rows + i * FieldConfig::kGeometry + v * R::kLanes);
      below = below && hn::AllTrue(d, hn::Le(hn::Abs(values), hn::Set(d, limit)));
    }
    numbers[count] = static_cast<std::uint32_t>(i);
    count += below ? 0 : 1;
  }
  return count;
}

/// 1/√v to 5e-6 for v ≥ 1e-37: a first guess from the bits (Lomont, "Fast inverse square root", 2003) and two of
/// Newton's steps. The same bits on every processor, and faster than a root and a division.
template <class D> HWY_INLINE hn::Vec<D> inverse_root(D d, hn::Vec<D> v) {
  const hn::RebindToSigned<D> di;
  const auto half = hn::Mul(hn::Set(d, 0.5F), v);
  auto guess = hn::BitCast(d, hn::Sub(hn::Set(di, 0x5F375A86), hn::ShiftRight<1>(hn::BitCast(di, v))));
  for (int step = 0; step < 2; ++step) {
    guess = hn::Mul(guess, hn::NegMulAdd(hn::Mul(half, guess), guess, hn::Set(d, 1.5F)));
  }
  return guess;
}

/// Adam for a vector of parameters, with its constants in registers.
template <class D> class Adam {
public:
  HWY_INLINE explicit Adam(const AdamStep& step)
      : rate_(hn::Set(D(), step.learning_rate)), epsilon_(hn::Set(D(), step.epsilon * step.epsilon)),
        fresh1_(hn::Set(D(), 1 - step.beta1)), beta2_(hn::Set(D(), step.beta2)), fresh2_(hn::Set(D(), 1 - step.beta2)) {
  }

  HWY_INLINE void update(float* parameters, float* gradients, float* first_moments, float* second_moments) const {
    const D d;
    const auto g = hn::LoadU(d, gradients);
    const auto m_before = hn::LoadU(d, first_moments);
    const auto v_before = hn::LoadU(d, second_moments);
    const auto p = hn::LoadU(d, parameters);
    const auto m = hn::MulAdd(fresh1_, hn::Sub(g, m_before), m_before);
    const auto v = hn::MulAdd(beta2_, v_before, hn::Mul(fresh2_, hn::Mul(g, g)));
    const auto next = hn::NegMulAdd(hn::Mul(rate_, m), inverse_root(d, hn::Add(v, epsilon_)), p);
    // A parameter without gradient keeps its value and moments (Müller et al. 2022, sec. 4).
    const auto moved = hn::Ne(g, hn::Zero(d));
    hn::StoreU(hn::IfThenElse(moved, next, p), d, parameters);
    hn::StoreU(hn::IfThenElse(moved, m, m_before), d, first_moments);
    hn::StoreU(hn::IfThenElse(moved, v, v_before), d, second_moments);
    hn::StoreU(hn::Zero(d), d, gradients);
  }

private:
  hn::Vec<D> rate_, epsilon_, fresh1_, beta2_, fresh2_;
};

void adam(const AdamStep& step, std::size_t count, float* parameters, float* gradients, float* first_moments,
          float* second_moments) {
  using Wide = hn::CappedTag<float, 16>;
  using Narrow = hn::CappedTag<float, kF>;
  constexpr std::size_t kLanes = hn::MaxLanes(Wide());
  const Adam<Wide> wide(step);
  const Adam<Narrow> narrow(step);
  const auto touched = [&](std::size_t i) HWY_ATTR {
    return !hn::AllTrue(Wide(), hn::Eq(hn::LoadU(Wide(), gradients + i), hn::Zero(Wide())));
  };
  const auto update_narrow = [&](std::size_t begin, std::size_t end) HWY_ATTR {
    for (std::size_t i = begin; i < end; i += hn::Lanes(Narrow())) {
      narrow.update(parameters + i, gradients + i, first_moments + i, second_moments + i);
    }
  };
  // Whole lines of memory: a level may begin in the middle of one.
  const bool aligned = reinterpret_cast<std::uintptr_t>(gradients) % (16 * sizeof(float)) == 0;
  const std::size_t head = aligned ? 0 : std::min<std::size_t>(kF, count);
  update_narrow(0, head);
  // A group is looked at while the one before it is updated: its memory is on the way by then, and no branch is guessed
  // wrong for each vector.
  constexpr std::size_t kGroup = 32;
  const auto look = [&](std::size_t begin) HWY_ATTR {
    std::uint32_t which = 0;
    const std::size_t vectors = begin < count ? std::min(kGroup, (count - begin) / kLanes) : 0;
    for (std::size_t i = 0; i < vectors; ++i) {
      const std::size_t at = begin + i * kLanes;
      if (!touched(at)) continue;
      which |= 1U << i;
      __builtin_prefetch(parameters + at);
      __builtin_prefetch(first_moments + at);
      __builtin_prefetch(second_moments + at);
    }
    return which;
  };
  std::uint32_t next = look(head);
  for (std::size_t begin = head; begin + kLanes <= count; begin += kGroup * kLanes) {
    std::uint32_t which = next;
    next = look(begin + kGroup * kLanes);
    for (; which != 0; which &= which - 1) {
      const std::size_t i = begin + static_cast<std::size_t>(std::countr_zero(which)) * kLanes;
      wide.update(parameters + i, gradients + i, first_moments + i, second_moments + i);
    }
  }
  update_narrow(head + (count - head) / kLanes * kLanes, count);
}

const char* instruction_set() { return hwy::TargetName(HWY_TARGET); }

} // namespace kinora::fields::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::fields::kernels {

HWY_EXPORT(encode);
HWY_EXPORT(dense);
HWY_EXPORT(accumulate_weight_gradient);
HWY_EXPORT(relu_backward);
HWY_EXPORT(scatter_level);
HWY_EXPORT(densities);
HWY_EXPORT(rows_above);
HWY_EXPORT(adam);
HWY_EXPORT(instruction_set);

void encode(std::span<const GridLevel> levels, const float* table, const Points& points, float* encodings) {
  HWY_DYNAMIC_DISPATCH(encode)(levels, table, points, encodings);
}
void dense(const float* in, std::size_t n, int inputs, const float* weights, int outputs, bool relu, float* out) {
  HWY_DYNAMIC_DISPATCH(dense)(in, n, inputs, weights, outputs, relu, out);
}
void accumulate_weight_gradient(const float* in, const float* out_gradient, std::size_t n, int inputs, int outputs,
                                float* gradient) {
  HWY_DYNAMIC_DISPATCH(accumulate_weight_gradient)(in, out_gradient, n, inputs, outputs, gradient);
}
void relu_backward(const float* activated, std::size_t count, float* gradient) {
  HWY_DYNAMIC_DISPATCH(relu_backward)(activated, count, gradient);
}
void scatter_level(const GridLevel& level, const Points& points, const float* feature_gradients, std::size_t stride,
                   float* table_gradient) {
  HWY_DYNAMIC_DISPATCH(scatter_level)(level, points, feature_gradients, stride, table_gradient);
}
void densities(const float* geometry, const float* lengths, std::size_t n, float* density, float* passing) {
  HWY_DYNAMIC_DISPATCH(densities)(geometry, lengths, n, density, passing);
}
std::size_t rows_above(const float* rows, std::size_t n, float limit, std::uint32_t* numbers) {
  return HWY_DYNAMIC_DISPATCH(rows_above)(rows, n, limit, numbers);
}
void adam(const AdamStep& step, std::size_t count, float* parameters, float* gradients, float* first_moments,
          float* second_moments) {
  HWY_DYNAMIC_DISPATCH(adam)(step, count, parameters, gradients, first_moments, second_moments);
}
const char* instruction_set() { return HWY_DYNAMIC_DISPATCH(instruction_set)(); }

} // namespace kinora::fields::kernels
#endif
