#include "ingest/depth/depth_cleaning.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ingest/depth/depth_cleaning_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>
// after highway.h
#include "core/sensor_noise_simd.h"
#include "core/vectors_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::ingest::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace vectors::HWY_NAMESPACE;

using Bytes = hn::Rebind<std::uint8_t, Floats>;

/// An image with a margin on every side, which can be read by whole vectors from there.
template <class T> class Padded {
public:
  Padded(int width, int height, int margin, T around)
      : stride_(static_cast<std::size_t>(width + 2 * margin) + kMaxLanes), margin_(static_cast<std::size_t>(margin)),
        values_(stride_ * static_cast<std::size_t>(height + 2 * margin), around) {}
  T* row(int v) { return values_.data() + (static_cast<std::size_t>(v) + margin_) * stride_ + margin_; }
  std::ptrdiff_t stride() const { return static_cast<std::ptrdiff_t>(stride_); }

private:
  std::size_t stride_, margin_;
  std::vector<T> values_;
};

/// The slope of a surface at each pixel, from neighbours of the same row or column that no jump separates.
class Cleaner {
public:
  Cleaner(const DepthImage& depth, const Intrinsics& intrinsics, const DepthCleaning& limits)
      : image_(depth), intrinsics_(intrinsics), limits_(limits), radius_(std::max(limits.gradient_radius, 1)),
        depth_(depth.width(), depth.height(), radius_, 0), valid_(depth.width(), depth.height(), 1, 0),
        steps_(depth.width(), depth.height(), radius_, 0), kept_(depth.width(), depth.height(), 1, 1) {}

  DepthImage run() {
    for (int v = 0; v < image_.height(); ++v) std::copy_n(image_.pixel(0, v), image_.width(), depth_.row(v));
    for (int v = 0; v < image_.height(); ++v) for_lanes([&](int u) { mark_steps(u, v); });
    for (int v = 0; v < image_.height(); ++v) {
      for_lanes([&](int u) { drop_isolated(u, v); });
      std::fill_n(valid_.row(v) + image_.width(), kMaxLanes, 0.0F);
    }
    bool above = false;
    for (int v = 0; v < image_.height(); ++v) {
      bool here = false;
      for_lanes([&](int u) { here = bridge_isolated(u, v) || here; });
      if (here || above) for_lanes([&](int u) { mark_steps(u, v); });
      above = here;
    }
    for (int v = 0; v < image_.height(); ++v) {
      // What lies beyond the row is not depth; beyond the picture it does not count as missing.
      for_lanes([&](int u) { keep(u, v); });
      std::fill_n(kept_.row(v) + image_.width(), kMaxLanes, 1.0F);
    }
    DepthImage result(image_.width(), image_.height());
    for (int v = 0; v < image_.height(); ++v) for_lanes([&](int u) { erode(u, v, result); });
    return result;
  }

private:
  // Of a step from the pixel before: along the row, along the column.
  static constexpr std::int32_t kAlong = 1, kDown = 2; // a surface goes on
  static constexpr std::int32_t kJumpAlong = 4, kJumpDown = 8;

  template <class Each> void for_lanes(const Each& each) const {
    for (int u = 0; u < image_.width(); u += static_cast<int>(hn::Lanes(Floats()))) each(u);
  }

  /// The depths of two neighbours that may lie on one surface differ by no more.
  F max_step(F a, F b) const {
    const F z = hn::Min(a, b);
    return hn::Max(hn::Mul(constant(static_cast<float>(limits_.max_jump)), z),
                   hn::Mul(constant(static_cast<float>(limits_.max_jump_sigmas)), depth_sigma(z)));
  }

  void mark_steps(int u, int v) {
    const Floats d;
    const Ints di;
    const float* at = depth_.row(v) + u;
    const F here = hn::LoadU(d, at);
    const auto step = [&](F before, std::int32_t joined, std::int32_t jump) {
      const F z = hn::Min(here, before);
      const Mask continues = hn::Le(hn::Abs(hn::Sub(here, before)), max_step(here, before));
      const I marks = hn::IfThenElse(hn::RebindMask(di, continues), hn::Set(di, joined), hn::Set(di, jump));
      return hn::IfThenElseZero(hn::RebindMask(di, hn::Gt(z, zero())), marks);
    };
    const I along = step(hn::LoadU(d, at - 1), kAlong, kJumpAlong);
    const I down = step(hn::LoadU(d, at - depth_.stride()), kDown, kJumpDown);
    hn::StoreU(hn::DemoteTo(Bytes(), hn::Or(along, down)), Bytes(), steps_.row(v) + u);
  }

  Mask has_mark(const std::uint8_t* steps, std::int32_t mark) const {
    const Ints di;
    const I marks = hn::PromoteTo(di, hn::LoadU(Bytes(), steps));
    return hn::RebindMask(Floats(), hn::Ne(hn::And(marks, hn::Set(di, mark)), hn::Zero(di)));
  }

  void drop_isolated(int u, int v) {
    const Floats d;
    const Bytes bytes;
    const std::uint8_t* steps = steps_.row(v) + u;
    const auto after = [&](std::ptrdiff_t step, std::int32_t marks) {
      return hn::And(hn::LoadU(bytes, steps + step), hn::Set(bytes, static_cast<std::uint8_t>(marks)));
    };
    const auto right = after(1, kAlong | kJumpAlong);
    const auto below = after(steps_.stride(), kDown | kJumpDown);
    const Ints di;
    const I marks = hn::PromoteTo(di, hn::Or(hn::LoadU(bytes, steps), hn::Or(right, below)));
    // It jumps somewhere, and is joined to nothing.
    const I joined = hn::And(marks, hn::Set(di, kAlong | kDown));
    const Mask isolated = hn::RebindMask(d, hn::And(hn::Ne(marks, hn::Zero(di)), hn::Eq(joined, hn::Zero(di))));
    hn::StoreU(hn::IfThenZeroElse(isolated, hn::LoadU(d, depth_.row(v) + u)), d, valid_.row(v) + u);
  }

  /// Gives a lone pixel, for as long as others are judged, the depth of the surface that it stands in; true if any.
  bool bridge_isolated(int u, int v) {
    const Floats d;
    float* at = depth_.row(v) + u;
    const float* valid = valid_.row(v) + u;
    const F z = hn::LoadU(d, at);
    const Mask isolated = hn::And(hn::Gt(z, zero()), hn::Le(hn::LoadU(d, valid), zero()));
    if (hn::AllFalse(d, isolated)) return false;
    F sum = zero();
    F count = zero();
    for (const std::ptrdiff_t step : {std::ptrdiff_t{1}, valid_.stride()}) {
      const F before = hn::LoadU(d, valid - step);
      const F after = hn::LoadU(d, valid + step);
      const Mask on_both_sides = hn::Gt(hn::Min(before, after), zero());
      sum = hn::Add(sum, hn::IfThenElseZero(on_both_sides, hn::Add(before, after)));
      count = hn::Add(count, hn::IfThenElseZero(on_both_sides, constant(2)));
    }
    Mask bridged = hn::And(isolated, hn::Gt(count, zero()));
    const F mean = hn::Div(sum, hn::Max(count, constant(1)));
    for (const int side : {-1, 1}) {
      for (const bool down : {false, true}) {
        const F other = hn::LoadU(d, valid + side * (down ? valid_.stride() : 1));
        const Mask jumps = hn::Gt(hn::Abs(hn::Sub(other, mean)), max_step(other, mean));
        bridged = hn::AndNot(hn::And(hn::Gt(other, zero()), jumps), bridged);
      }
    }
    hn::StoreU(hn::IfThenElse(bridged, mean, z), d, at);
    return !hn::AllFalse(d, bridged);
  }

  /// Least-squares slope of depth per pixel along a line of pixels, over the neighbours that joined steps lead to.
  F gradient(const float* z, const std::uint8_t* steps, std::ptrdiff_t z_stride, std::ptrdiff_t step_stride,
             std::int32_t joined) const {
    const Floats d;
    const Bytes bytes;
    auto all = hn::Set(bytes, static_cast<std::uint8_t>(joined));
    for (std::ptrdiff_t i = 1 - limits_.gradient_radius; i <= limits_.gradient_radius; ++i) {
      all = hn::And(all, hn::LoadU(bytes, steps + i * step_stride));
    }
    if (hn::AllTrue(bytes, hn::Ne(all, hn::Zero(bytes)))) { // the usual case: the mean of x vanishes
      F product = zero();
      float spread = 0;
      for (std::ptrdiff_t i = 1; i <= limits_.gradient_radius; ++i) {
        const auto x = static_cast<float>(i);
        const F across = hn::Sub(hn::LoadU(d, z + i * z_stride), hn::LoadU(d, z - i * z_stride));
        product = hn::MulAdd(constant(x), across, product);
        spread += 2 * x * x;
      }
      return hn::Mul(product, constant(1 / std::max(spread, 1.0F)));
    }
    const F here = hn::LoadU(d, z);
    F count = constant(1), sum_x = zero(), sum_z = zero(), sum_xx = zero(), sum_xz = zero(); // x and z from the pixel
    const auto add = [&](Mask reached, F x, F other) {
      const F offset = hn::IfThenElseZero(reached, hn::Sub(other, here));
      const F along = hn::IfThenElseZero(reached, x);
      count = hn::Add(count, hn::IfThenElseZero(reached, constant(1)));
      sum_x = hn::Add(sum_x, along);
      sum_z = hn::Add(sum_z, offset);
      sum_xx = hn::MulAdd(along, along, sum_xx);
      sum_xz = hn::MulAdd(along, offset, sum_xz);
    };
    Mask ahead = hn::Eq(here, here);
    Mask behind = ahead;
    for (std::ptrdiff_t i = 1; i <= limits_.gradient_radius; ++i) {
      const F x = constant(static_cast<float>(i));
      behind = hn::And(behind, has_mark(steps - (i - 1) * step_stride, joined));
      add(behind, hn::Neg(x), hn::LoadU(d, z - i * z_stride));
      ahead = hn::And(ahead, has_mark(steps + i * step_stride, joined));
      add(ahead, x, hn::LoadU(d, z + i * z_stride));
    }
    const F spread = hn::NegMulAdd(sum_x, sum_x, hn::Mul(count, sum_xx));
    const F product = hn::NegMulAdd(sum_x, sum_z, hn::Mul(count, sum_xz));
    return hn::IfThenElseZero(hn::Gt(spread, zero()), hn::Div(product, spread));
  }

  /// With z(u, v) the depth at a pixel, the normal is (fx·z_u, fy·z_v, −z − (u−cx)·z_u − (v−cy)·z_v) up to length, and
  /// its product with the ray ((u−cx)/fx, (v−cy)/fy, 1) is −z.
  void keep(int u, int v) {
    const Floats d;
    const float* at = depth_.row(v) + u;
    const std::uint8_t* steps = steps_.row(v) + u;
    const F z = hn::LoadU(d, at);
    Mask kept = hn::Gt(z, zero());
    kept = hn::AndNot(has_mark(steps, kJumpAlong | kJumpDown), kept);
    kept = hn::AndNot(hn::Or(has_mark(steps + 1, kJumpAlong), has_mark(steps + steps_.stride(), kJumpDown)), kept);
    if (!hn::AllFalse(d, kept)) {
      const F z_u = gradient(at, steps, 1, 1, kAlong);
      const F z_v = gradient(at, steps, depth_.stride(), steps_.stride(), kDown);
      const F fx = constant(static_cast<float>(intrinsics_.fx));
      const F fy = constant(static_cast<float>(intrinsics_.fy));
      const F x = hn::Add(hn::Iota(d, 0), constant(static_cast<float>(u - intrinsics_.cx)));
      const F y = constant(static_cast<float>(v - intrinsics_.cy));
      const Vec3 normal{hn::Mul(fx, z_u), hn::Mul(fy, z_v), hn::Neg(hn::MulAdd(x, z_u, hn::MulAdd(y, z_v, z)))};
      const Vec3 ray{hn::Div(x, fx), hn::Div(y, fy), constant(1)};
      const double sine = std::sin(limits_.min_incidence);
      const F min_squared_depth =
          hn::Mul(constant(static_cast<float>(sine * sine)), hn::Mul(dot(normal, normal), dot(ray, ray)));
      kept = hn::And(kept, hn::Ge(hn::Mul(z, z), min_squared_depth));
    }
    hn::StoreU(hn::IfThenElseZero(kept, z), d, kept_.row(v) + u);
  }

  void erode(int u, int v, DepthImage& result) {
    const Floats d;
    const float* at = kept_.row(v) + u;
    const auto is_kept = [&](std::ptrdiff_t step) { return hn::Gt(hn::LoadU(d, at + step), zero()); };
    Mask inside = hn::And(hn::And(is_kept(-1), is_kept(1)), hn::And(is_kept(-kept_.stride()), is_kept(kept_.stride())));
    inside = hn::And(inside, hn::Gt(hn::LoadU(d, valid_.row(v) + u), zero()));
    HWY_ALIGN float eroded[kMaxLanes];
    hn::Store(hn::IfThenElseZero(inside, hn::LoadU(d, at)), d, eroded);
    const auto count = std::min(hn::Lanes(d), static_cast<std::size_t>(image_.width() - u));
    std::memcpy(result.pixel(u, v), eroded, count * sizeof(float));
  }

  const DepthImage& image_;
  const Intrinsics& intrinsics_;
  const DepthCleaning& limits_;
  int radius_;
  Padded<float> depth_;
  Padded<float> valid_; ///< 0 where a pixel is lone
  Padded<std::uint8_t> steps_;
  Padded<float> kept_; ///< 0 where it is not
};

void clean(const DepthImage& depth, const Intrinsics& intrinsics, const DepthCleaning& limits, DepthImage& result) {
  result = Cleaner(depth, intrinsics, limits).run();
}

} // namespace kinora::ingest::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::ingest {

HWY_EXPORT(clean);

DepthImage clean_depth(const DepthImage& depth, const Intrinsics& intrinsics, const DepthCleaning& limits) {
  DepthImage result;
  HWY_DYNAMIC_DISPATCH(clean)(depth, intrinsics, limits, result);
  return result;
}

} // namespace kinora::ingest
#endif
