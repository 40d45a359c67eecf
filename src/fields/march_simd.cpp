#include "fields/march.h"
#include "fields/ray_batch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/march_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>
// after highway.h
#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
constexpr std::size_t kMostLanes = 16;

/// The lanes' rays, apart by axis; lanes beyond the last ray stand outside.
struct Lanes {
  HWY_ALIGN float origin[3][kMostLanes];
  HWY_ALIGN float direction[3][kMostLanes];
  HWY_ALIGN float begin[kMostLanes];
};

/// Bilinear interpolation among the four samples of two pairs, side by side in x.
HWY_INLINE VF interpolate(VI square, VF fx, VF fy) {
  const DF df;
  const DI di;
  const auto low = hn::Set(di, 255);
  const auto b00 = hn::ConvertTo(df, hn::And(square, low));
  const auto b01 = hn::ConvertTo(df, hn::And(hn::ShiftRight<8>(square), low));
  const auto b10 = hn::ConvertTo(df, hn::And(hn::ShiftRight<16>(square), low));
  const auto b11 = hn::ConvertTo(df, hn::And(hn::ShiftRight<24>(square), low));
  const auto y0 = hn::MulAdd(fx, hn::Sub(b10, b00), b00);
  const auto y1 = hn::MulAdd(fx, hn::Sub(b11, b01), b01);
  return hn::MulAdd(fy, hn::Sub(y1, y0), y0);
}

struct Position {
  VF fraction[3];
  VI low[3];
};

/// Level of a byte at a position of bricks that exist.
HWY_INLINE VF level_at(const std::uint16_t* pairs, VI brick, const Position& at) {
  const DI di;
  constexpr int kSide = DensityBricks::kSide;
  const auto in_brick = hn::Set(di, kSide - 1);
  const auto x = hn::And(at.low[0], in_brick);
  const auto y = hn::And(at.low[1], in_brick);
  const auto z = hn::And(at.low[2], in_brick);
  const auto row = hn::Add(hn::ShiftLeft<3>(z), y);
  const auto local = hn::Add(hn::Add(hn::ShiftLeft<3>(row), row), x);
  static_assert(DensityBricks::kLevels == 9);
  const auto pair = hn::Add(hn::Mul(brick, hn::Set(di, DensityBricks::kPairs)), local);
  const auto offset = hn::ShiftLeft<1>(pair); // bytes
  constexpr std::size_t kLayer = std::size_t{kSide} * DensityBricks::kLevels;
  const auto* near_base = reinterpret_cast<const std::int32_t*>(pairs);
  const auto* far_base = reinterpret_cast<const std::int32_t*>(pairs + kLayer);
  const auto near = interpolate(hn::GatherOffset(di, near_base, offset), at.fraction[0], at.fraction[1]);
  const auto far = interpolate(hn::GatherOffset(di, far_base, offset), at.fraction[0], at.fraction[1]);
  return hn::MulAdd(at.fraction[2], hn::Sub(far, near), near);
}

void march_lanes(const DensityBricks& bricks, const Lanes& lanes, float optical_length, std::size_t count,
                 MarchRun* runs) {
  const DF df;
  const DI di;
  static_assert(DensityBricks::kSide == 8);
  const auto zero = hn::Zero(df);
  const auto one = hn::Set(df, 1.0F);
  const auto limit = hn::Set(df, static_cast<float>(bricks.bricks_per_side() * DensityBricks::kSide));
  const auto per_side = hn::Set(di, bricks.bricks_per_side());
  const auto scale = hn::Set(df, DensityBricks::kStep);
  const auto lowest = hn::Set(df, DensityBricks::kLowest);
  const auto length = hn::Set(df, -optical_length);
  for (std::size_t first = 0; first < count; first += hn::Lanes(df)) {
    const auto begin = hn::Load(df, lanes.begin + first);
    auto step = begin;
    auto transmittance = one;
    auto median = hn::Set(df, -1.0F);
    auto weighted = zero; // by what is taken away there: steps from the begin …
    auto squared = zero;  // … and their squares
    auto reason = hn::Zero(di);
    auto active = hn::Lt(hn::Iota(df, 0), hn::Set(df, static_cast<float>(count - first)));
    while (!hn::AllFalse(df, active)) {
      const auto middle = hn::Add(step, hn::Set(df, 0.5F));
      Position at;
      auto inside = active;
      for (int a = 0; a < 3; ++a) {
        const auto q =
            hn::MulAdd(middle, hn::Load(df, lanes.direction[a] + first), hn::Load(df, lanes.origin[a] + first));
        inside = hn::And(inside, hn::And(hn::Ge(q, zero), hn::Lt(q, limit)));
        at.low[a] = hn::ConvertTo(di, hn::IfThenElseZero(inside, q));
        at.fraction[a] = hn::Sub(q, hn::ConvertTo(df, at.low[a]));
      }
      const auto row = hn::Add(hn::Mul(hn::ShiftRight<3>(at.low[2]), per_side), hn::ShiftRight<3>(at.low[1]));
      const auto place = hn::Add(hn::Mul(row, per_side), hn::ShiftRight<3>(at.low[0]));
      const auto brick = hn::GatherIndex(di, bricks.index(), place);
      inside = hn::And(inside, hn::RebindMask(df, hn::Gt(brick, hn::Set(di, -1))));
      const auto raw = hn::MulAdd(level_at(bricks.pairs(), hn::Max(brick, hn::Zero(di)), at), scale, lowest);
      const auto passing = hn::Exp(df, hn::Mul(hn::Exp(df, raw), length));
      const auto weight = hn::IfThenElseZero(inside, hn::Sub(transmittance, hn::Mul(transmittance, passing)));
      const auto moment = hn::Mul(weight, hn::Sub(middle, begin));
      weighted = hn::Add(weighted, moment);
      squared = hn::MulAdd(moment, hn::Sub(middle, begin), squared);
      const auto behind = hn::Sub(transmittance, weight);
      const auto half = hn::Set(df, 0.5F);
      median = hn::IfThenElse(hn::And(hn::Gt(transmittance, half), hn::Le(behind, half)), middle, median);
      transmittance = behind;
      step = hn::IfThenElse(inside, hn::Add(step, one), step);
      const auto left = hn::AndNot(inside, active);
      const auto opaque = hn::And(inside, hn::Le(transmittance, hn::Set(df, kOpaque)));
      const auto gap = hn::And(hn::And(inside, hn::Gt(passing, hn::Set(df, 1 - kRunEnds))),
                               hn::Lt(transmittance, hn::Set(df, 1 - kRunBegins)));
      reason = hn::IfThenElse(hn::RebindMask(di, opaque), hn::Set(di, static_cast<int>(RunEnd::kOpaque)), reason);
      reason = hn::IfThenElse(hn::RebindMask(di, left), hn::Set(di, static_cast<int>(RunEnd::kLeft)), reason);
      active = hn::AndNot(hn::Or(gap, opaque), inside);
    }
    HWY_ALIGN float opacities[kMostLanes], means[kMostLanes], medians[kMostLanes], spreads[kMostLanes],
        ends[kMostLanes];
    HWY_ALIGN std::int32_t reasons[kMostLanes];
    const auto opacity = hn::Sub(one, transmittance);
    const auto normaliser = hn::Div(one, hn::Max(opacity, hn::Set(df, 1e-12F)));
    const auto mean = hn::Mul(weighted, normaliser);
    const auto variance = hn::NegMulAdd(mean, mean, hn::Mul(squared, normaliser));
    hn::Store(opacity, df, opacities);
    const auto mean_step = hn::Add(begin, mean);
    hn::Store(mean_step, df, means);
    hn::Store(hn::IfThenElse(hn::Lt(median, zero), mean_step, median), df, medians);
    hn::Store(hn::Sqrt(hn::Max(variance, zero)), df, spreads);
    hn::Store(step, df, ends);
    hn::Store(reason, di, reasons);
    for (std::size_t i = 0; i < std::min<std::size_t>(hn::Lanes(df), count - first); ++i) {
      runs[first + i] = {opacities[i], means[i], medians[i], spreads[i], ends[i], static_cast<RunEnd>(reasons[i])};
    }
  }
}

void march(const DensityBricks& bricks, const MarchRay* rays, const float* begin, std::size_t n, float optical_length,
           MarchRun* runs) {
  if (bricks.count() == 0) {
    for (std::size_t i = 0; i < n; ++i) runs[i] = {0, 0, 0, 0, begin[i], RunEnd::kLeft};
    return;
  }
  Lanes lanes{};
  for (std::size_t first = 0; first < n; first += kMostLanes) {
    const std::size_t count = std::min(kMostLanes, n - first);
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t a = 0; a < 3; ++a) {
        lanes.origin[a][i] = rays[first + i].origin[a];
        lanes.direction[a][i] = rays[first + i].direction[a];
      }
      lanes.begin[i] = begin[first + i];
    }
    march_lanes(bricks, lanes, optical_length, count, runs + first);
  }
}

} // namespace kinora::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::fields {

HWY_EXPORT(march);

void march(const DensityBricks& bricks, const MarchRay* rays, const float* begin, std::size_t n, float optical_length,
           MarchRun* runs) {
  HWY_DYNAMIC_DISPATCH(march)(bricks, rays, begin, n, optical_length, runs);
}

} // namespace kinora::fields
#endif
