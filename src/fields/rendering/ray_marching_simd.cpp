#include "fields/rendering/ray_marching.h"

#include <algorithm>
#include <cmath>

#include "fields/network/ray_batch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/rendering/ray_marching_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
constexpr std::size_t kMaxLanes = 16;

/// One ray per lane, from the beginning of its run.
struct Lanes {
  HWY_ALIGN float origin[3][kMaxLanes];
  HWY_ALIGN float direction[3][kMaxLanes];
  HWY_ALIGN float begin[kMaxLanes];
  HWY_ALIGN float step[kMaxLanes];
  HWY_ALIGN float transmittance[kMaxLanes];
  HWY_ALIGN float median[kMaxLanes];   // step at which half of the light is gone; negative before
  HWY_ALIGN float weighted[kMaxLanes]; // steps from the beginning, by the light that is taken away there …
  HWY_ALIGN float squared[kMaxLanes];  // … and their squares
  HWY_ALIGN std::int32_t reason[kMaxLanes];
  HWY_ALIGN std::int32_t active[kMaxLanes]; // −1 or 0
  std::size_t ray[kMaxLanes];
  bool is_busy[kMaxLanes] = {};

  void start(std::size_t lane, std::size_t number, const MarchRay& from, float at) {
    for (std::size_t a = 0; a < 3; ++a) {
      origin[a][lane] = from.origin[a];
      direction[a][lane] = from.direction[a];
    }
    begin[lane] = step[lane] = at;
    transmittance[lane] = 1;
    median[lane] = -1;
    weighted[lane] = squared[lane] = 0;
    reason[lane] = 0;
    active[lane] = -1;
    ray[lane] = number;
    is_busy[lane] = true;
  }
  MarchRun run(std::size_t lane) const {
    const float opacity = 1 - transmittance[lane];
    const float normaliser = 1 / std::max(opacity, 1e-12F);
    const float mean = weighted[lane] * normaliser;
    const float variance = squared[lane] * normaliser - mean * mean;
    return {opacity,
            begin[lane] + mean,
            median[lane] < 0 ? begin[lane] + mean : median[lane],
            std::sqrt(std::max(variance, 0.0F)),
            step[lane],
            static_cast<RunEnd>(reason[lane])};
  }
};

/// The rays that are still to be followed: lanes that have ended are given the next ones.
class Queue {
public:
  Queue(const MarchRay* rays, const float* begin, std::size_t n, MarchRun* runs)
      : rays_(rays), begin_(begin), n_(n), runs_(runs) {}
  bool empty() const { return next_ == n_; }
  /// False once all have ended.
  bool refill(Lanes& lanes, std::size_t count) {
    bool any = false;
    for (std::size_t i = 0; i < count; ++i) {
      if (lanes.active[i] == 0) {
        if (lanes.is_busy[i]) runs_[lanes.ray[i]] = lanes.run(i);
        lanes.is_busy[i] = false;
        if (empty()) continue;
        lanes.start(i, next_, rays_[next_], begin_[next_]);
        ++next_;
      }
      any = true;
    }
    return any;
  }

private:
  const MarchRay* rays_;
  const float* begin_;
  std::size_t n_;
  MarchRun* runs_;
  std::size_t next_ = 0;
};

/// 2ˣ to 3.4e-6 of itself, exact at whole numbers; x at most 127, below −126 as there. Half the work of hn::Exp.
HWY_INLINE VF exp2(VF x) {
  const DF df;
  const DI di;
  x = hn::Max(x, hn::Set(df, -126.0F));
  const auto whole_steps = hn::Floor(x);
  const auto f = hn::Sub(x, whole_steps);
  auto p = hn::MulAdd(hn::Set(df, 0.01355575F), f, hn::Set(df, 0.05203237F));
  p = hn::MulAdd(p, f, hn::Set(df, 0.24137976F));
  p = hn::MulAdd(p, f, hn::Set(df, 0.69303212F));
  p = hn::MulAdd(p, f, hn::Set(df, 1.0F));
  return hn::BitCast(df, hn::Add(hn::BitCast(di, p), hn::ShiftLeft<23>(hn::ConvertTo(di, whole_steps))));
}

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
  const auto near_square = hn::GatherOffset(di, near_base, offset);
  const auto far_square = hn::GatherOffset(di, far_base, offset);
  const auto near = interpolate(near_square, at.fraction[0], at.fraction[1]);
  const auto far = interpolate(far_square, at.fraction[0], at.fraction[1]);
  return hn::MulAdd(at.fraction[2], hn::Sub(far, near), near);
}

void march(const DensityBricks& bricks, const MarchRay* rays, const float* begins, std::size_t n, float optical_length,
           MarchRun* runs, const std::int32_t* index) {
  if (bricks.count() == 0) {
    for (std::size_t i = 0; i < n; ++i) runs[i] = {0, 0, 0, 0, begins[i], RunEnd::kLeft};
    return;
  }
  const DF df;
  const DI di;
  static_assert(DensityBricks::kSide == 8);
  const auto zero = hn::Zero(df);
  const auto one = hn::Set(df, 1.0F);
  const auto half = hn::Set(df, 0.5F);
  const auto limit = hn::Set(df, static_cast<float>(bricks.bricks_per_side() * DensityBricks::kSide));
  const auto per_side = hn::Set(di, bricks.bricks_per_side());
  // Of levels: the logarithm of the optical depth of a step; all to the base of two.
  constexpr float kLog2E = 1.44269504F;
  const auto scale = hn::Set(df, kLog2E * DensityBricks::kStep);
  const auto lowest = hn::Set(df, kLog2E * DensityBricks::kLowest + std::log2(kLog2E * optical_length));
  const std::size_t lane_count = hn::Lanes(df);
  Lanes lanes{};
  Queue queue(rays, begins, n, runs);
  while (queue.refill(lanes, lane_count)) {
    // As long as there are others to follow, at most a quarter of the lanes may stand idle.
    const std::size_t enough = queue.empty() ? 0 : lane_count - std::max<std::size_t>(1, lane_count / 4);
    const auto begin = hn::Load(df, lanes.begin);
    auto step = hn::Load(df, lanes.step);
    auto end = step;
    auto transmittance = hn::Load(df, lanes.transmittance);
    auto median = hn::Load(df, lanes.median);
    auto weighted = hn::Load(df, lanes.weighted);
    auto squared = hn::Load(df, lanes.squared);
    auto reason = hn::Load(di, lanes.reason);
    auto active = hn::RebindMask(df, hn::Lt(hn::Load(di, lanes.active), hn::Zero(di)));
    do {
      const auto middle = hn::Add(step, half);
      Position at;
      auto inside = active;
      for (int a = 0; a < 3; ++a) {
        const auto q = hn::MulAdd(middle, hn::Load(df, lanes.direction[a]), hn::Load(df, lanes.origin[a]));
        const auto is_inside = hn::And(hn::Ge(q, zero), hn::Lt(q, limit));
        inside = hn::And(inside, is_inside);
        at.low[a] = hn::ConvertTo(di, hn::IfThenElseZero(is_inside, q));
        at.fraction[a] = hn::Sub(q, hn::ConvertTo(df, at.low[a]));
      }
      const auto row = hn::Add(hn::Mul(hn::ShiftRight<3>(at.low[2]), per_side), hn::ShiftRight<3>(at.low[1]));
      const auto brick_index = hn::Add(hn::Mul(row, per_side), hn::ShiftRight<3>(at.low[0]));
      const auto brick = hn::GatherIndex(di, index, brick_index);
      inside = hn::And(inside, hn::RebindMask(df, hn::Gt(brick, hn::Set(di, -1))));
      const auto depth = hn::MulAdd(level_at(bricks.pairs(), hn::Max(brick, hn::Zero(di)), at), scale, lowest);
      const auto step_transmittance = exp2(hn::Neg(exp2(depth)));
      const auto weight =
          hn::IfThenElseZero(inside, hn::Sub(transmittance, hn::Mul(transmittance, step_transmittance)));
      const auto moment = hn::Mul(weight, hn::Sub(middle, begin));
      weighted = hn::Add(weighted, moment);
      squared = hn::MulAdd(moment, hn::Sub(middle, begin), squared);
      const auto behind = hn::Sub(transmittance, weight);
      median = hn::IfThenElse(hn::And(hn::Gt(transmittance, half), hn::Le(behind, half)), middle, median);
      transmittance = behind;
      // Lanes that have ended go on, unseen: where the next sample lies must not wait for what this one finds.
      step = hn::Add(step, one);
      end = hn::IfThenElse(inside, step, end);
      const auto left = hn::AndNot(inside, active);
      const auto opaque = hn::And(inside, hn::Le(transmittance, hn::Set(df, kOpaque)));
      const auto gap = hn::And(hn::And(inside, hn::Gt(step_transmittance, hn::Set(df, 1 - kRunEnds))),
                               hn::Lt(transmittance, hn::Set(df, 1 - kRunBegins)));
      reason = hn::IfThenElse(hn::RebindMask(di, opaque), hn::Set(di, static_cast<int>(RunEnd::kOpaque)), reason);
      reason = hn::IfThenElse(hn::RebindMask(di, left), hn::Set(di, static_cast<int>(RunEnd::kLeft)), reason);
      active = hn::AndNot(hn::Or(gap, opaque), inside);
    } while (hn::CountTrue(df, active) > enough);
    hn::Store(end, df, lanes.step);
    hn::Store(transmittance, df, lanes.transmittance);
    hn::Store(median, df, lanes.median);
    hn::Store(weighted, df, lanes.weighted);
    hn::Store(squared, df, lanes.squared);
    hn::Store(reason, di, lanes.reason);
    hn::Store(hn::VecFromMask(di, hn::RebindMask(di, active)), di, lanes.active);
  }
}

} // namespace kinora::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::fields {

HWY_EXPORT(march);

void march(const DensityBricks& bricks, const MarchRay* rays, const float* begin, std::size_t n, float optical_length,
           MarchRun* runs, const std::int32_t* index) {
  HWY_DYNAMIC_DISPATCH(march)
  (bricks, rays, begin, n, optical_length, runs, index == nullptr ? bricks.index() : index);
}

} // namespace kinora::fields
#endif
