#include "tracking/view/silhouette.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tracking/view/silhouette_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kMaxLanes = 16;
constexpr std::int32_t kBeyond = 1 << 30;
using Ints = hn::CappedTag<std::int32_t, kMaxLanes>;
using I = hn::Vec<Ints>;

/// Offsets of a row's pixels and their squared lengths; around them others from which nothing is taken.
class Row {
public:
  explicit Row(std::size_t width)
      : width_(width), x_(width + 2 * kMaxLanes), y_(width + 2 * kMaxLanes), squared_(width + 2 * kMaxLanes) {
    close();
  }

  std::int32_t* x() { return x_.data() + kMaxLanes; }
  std::int32_t* y() { return y_.data() + kMaxLanes; }
  std::int32_t* squared() { return squared_.data() + kMaxLanes; }

  // Pairs of 16 bits, x below y.
  void load(const std::int16_t* offsets) {
    const Ints d;
    HWY_ALIGN std::int32_t packed[kMaxLanes] = {};
    for (std::size_t u = 0; u < width_; u += hn::Lanes(d)) {
      std::memcpy(packed, offsets + 2 * u, sizeof(std::int32_t) * std::min(hn::Lanes(d), width_ - u));
      const I both = hn::Load(d, packed);
      const I best_x = hn::ShiftRight<16>(hn::ShiftLeft<16>(both));
      const I best_y = hn::ShiftRight<16>(both);
      hn::StoreU(best_x, d, x() + u);
      hn::StoreU(best_y, d, y() + u);
      hn::StoreU(hn::Add(hn::Mul(best_x, best_x), hn::Mul(best_y, best_y)), d, squared() + u);
    }
    close();
  }

  void store(std::int16_t* offsets) {
    const Ints d;
    HWY_ALIGN std::int32_t packed[kMaxLanes];
    for (std::size_t u = 0; u < width_; u += hn::Lanes(d)) {
      const I low = hn::And(hn::LoadU(d, x() + u), hn::Set(d, 0xFFFF));
      hn::Store(hn::Or(low, hn::ShiftLeft<16>(hn::LoadU(d, y() + u))), d, packed);
      std::memcpy(offsets + 2 * u, packed, sizeof(std::int32_t) * std::min(hn::Lanes(d), width_ - u));
    }
  }

  // What the neighbours of the row before know, where that is nearer.
  void propagate_row(Row& last, std::int32_t dv) {
    const Ints d;
    for (std::size_t u = 0; u < width_; u += hn::Lanes(d)) {
      I best = hn::LoadU(d, squared() + u);
      if (hn::AllTrue(d, hn::Eq(best, hn::Zero(d)))) continue;
      I best_x = hn::LoadU(d, x() + u);
      I best_y = hn::LoadU(d, y() + u);
      for (std::int32_t du = -1; du <= 1; ++du) {
        const I from_x = hn::LoadU(d, last.x() + u + du);
        const I from_y = hn::LoadU(d, last.y() + u + du);
        // (x + du)² + (y + dv)²
        const I half = hn::Add(hn::Mul(from_x, hn::Set(d, du)), hn::Mul(from_y, hn::Set(d, dv)));
        const I there = hn::Add(hn::LoadU(d, last.squared() + u + du),
                                hn::Add(hn::ShiftLeft<1>(half), hn::Set(d, du * du + dv * dv)));
        const auto is_nearer = hn::Lt(there, best);
        best_x = hn::IfThenElse(is_nearer, hn::Add(from_x, hn::Set(d, du)), best_x);
        best_y = hn::IfThenElse(is_nearer, hn::Add(from_y, hn::Set(d, dv)), best_y);
        best = hn::Min(there, best);
      }
      hn::StoreU(best_x, d, x() + u);
      hn::StoreU(best_y, d, y() + u);
      hn::StoreU(best, d, squared() + u);
    }
    close();
  }

  // What neighbours of the same row know, from each pixel to the next, where that is nearer.
  void propagate_along() {
    const std::size_t lanes = hn::Lanes(Ints());
    for (std::size_t u = 0; u < width_; u += lanes) {
      if (may_propagate(u, -1)) {
        for (std::size_t i = u; i < std::min(u + lanes, width_); ++i) take(i, -1);
      }
    }
    for (std::size_t u = (width_ + lanes - 1) / lanes * lanes; u > 0;) {
      u -= lanes;
      if (may_propagate(u, 1)) {
        for (std::size_t i = std::min(u + lanes, width_); i > u; --i) take(i - 1, 1);
      }
    }
  }

private:
  void close() {
    std::fill_n(squared_.data(), kMaxLanes, kBeyond);
    std::fill_n(squared() + width_, kMaxLanes, kBeyond);
  }

  // Without any of these, no pixel from `u` on takes what its neighbour knows: nor what that would have taken.
  bool may_propagate(std::size_t u, std::int32_t du) {
    const Ints d;
    const std::ptrdiff_t from = static_cast<std::ptrdiff_t>(u) + du;
    const I twice_x = hn::ShiftLeft<1>(hn::LoadU(d, x() + from));
    const I there = hn::Add(hn::LoadU(d, squared() + from), hn::Set(d, 1));
    return !hn::AllFalse(
        d, hn::Lt(du > 0 ? hn::Add(there, twice_x) : hn::Sub(there, twice_x), hn::LoadU(d, squared() + u)));
  }

  void take(std::size_t u, std::int32_t du) {
    const std::ptrdiff_t from = static_cast<std::ptrdiff_t>(u) + du;
    const std::int32_t there = squared()[from] + 2 * du * x()[from] + 1; // (x + du)² + y²
    if (there >= squared()[u]) return;
    x()[u] = x()[from] + du;
    y()[u] = y()[from];
    squared()[u] = there;
  }

  std::size_t width_;
  std::vector<std::int32_t> x_, y_, squared_;
};

void sweep(Image<std::int16_t>& offsets) {
  const auto width = static_cast<std::size_t>(offsets.width());
  Row row(width);
  Row last(width);
  const auto sweep_row = [&](int v, int dv) {
    std::swap(row, last);
    row.load(offsets.pixel(0, v));
    if (v + dv >= 0 && v + dv < offsets.height()) row.propagate_row(last, dv);
    row.propagate_along();
    row.store(offsets.pixel(0, v));
  };
  for (int v = 0; v < offsets.height(); ++v) sweep_row(v, -1);
  for (int v = offsets.height() - 1; v >= 0; --v) sweep_row(v, 1);
}

} // namespace kinora::tracking::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::tracking {

HWY_EXPORT(sweep);

Image<std::int16_t> offsets_to_silhouette(const LabelImage& allowed) {
  Image<std::int16_t> offsets(allowed.width(), allowed.height(), 2);
  const int far = 2 * (allowed.width() + allowed.height()); // and not nearer after any way across the picture
  std::int16_t* offset = offsets.data();
  for (const std::uint8_t value : allowed.values()) {
    const auto start = static_cast<std::int16_t>(value == 0 ? far : 0);
    *offset++ = start;
    *offset++ = start;
  }
  HWY_DYNAMIC_DISPATCH(sweep)(offsets);
  return offsets;
}

} // namespace kinora::tracking
#endif
