#include "fields/network/mlp.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/network/mlp_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

#include "fields/model/field.h"
#include "fields/network/row_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

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

} // namespace kinora::fields::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::fields::kernels {

HWY_EXPORT(dense);
HWY_EXPORT(accumulate_weight_gradient);
HWY_EXPORT(relu_backward);
HWY_EXPORT(rows_above);

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
std::size_t rows_above(const float* rows, std::size_t n, float limit, std::uint32_t* numbers) {
  return HWY_DYNAMIC_DISPATCH(rows_above)(rows, n, limit, numbers);
}

} // namespace kinora::fields::kernels
#endif
