#include "tracking/bent_row.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tracking/bent_row_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kVoxels = BentRow::kVoxels;
using Floats = hn::CappedTag<float, kVoxels>;
using Ints = hn::RebindToSigned<Floats>;
using F = hn::Vec<Floats>;
using I = hn::Vec<Ints>;
using Mask = hn::Mask<Floats>;

F constant(float value) { return hn::Set(Floats(), value); }

/// Voxels side by side, from number `begin` of the row.
class VoxelLanes {
public:
  VoxelLanes(const BentImages& view, const BentRow& row, std::size_t begin) : view_(view) {
    const Floats d;
    const F number = hn::Add(hn::Iota(d, 0), constant(static_cast<float>(begin)));
    const F half = constant(0.5F * kVoxels);
    const Mask behind = hn::Ge(number, half);
    const F share = hn::Div(hn::Sub(number, hn::IfThenElseZero(behind, half)), half);
    const auto place = [&](std::size_t axis) {
      const F middle = constant(row.along[1][axis]);
      const F from = hn::IfThenElse(behind, middle, constant(row.along[0][axis]));
      const F to = hn::IfThenElse(behind, constant(row.along[2][axis]), middle);
      return hn::MulAdd(share, hn::Sub(to, from), from);
    };
    x_ = place(0);
    y_ = place(1);
    z_ = place(2);
    along_ = hn::MulAdd(number, constant(row.voxel), constant(row.first[0]));
    across_ = {row.first[1], row.first[2]};
    const F known = hn::IfThenElse(behind, constant(row.known[1] ? 1.0F : 0.0F), constant(row.known[0] ? 1.0F : 0.0F));
    find_pixels(hn::And(hn::Gt(known, hn::Zero(d)), hn::Gt(z_, constant(view.nearest))));
  }

  void fuse(float* distance, float* weight, float* intensity) const {
    const Floats d;
    const F trust = hn::GatherIndex(d, view_.weights, pixel_);
    const F off = distance_to_plane();
    Mask taught = hn::And(inside_, hn::Gt(trust, hn::Zero(d)));
    taught = hn::And(taught, hn::Lt(hn::Abs(off), constant(view_.truncation)));
    if (hn::AllFalse(d, taught)) return;
    taught = hn::And(taught, shows());
    if (hn::AllFalse(d, taught)) return;
    const F depth = hn::Min(hn::MulAdd(off, constant(1 / view_.truncation), constant(1)), constant(1));
    const F added = hn::Mul(trust, hn::Mul(depth, depth)); // less behind the surface
    const F old = hn::LoadU(d, weight);
    const F share = hn::Div(added, hn::Add(old, added));
    const auto average = [&](F value, float* values) {
      const F before = hn::LoadU(d, values);
      hn::StoreU(hn::IfThenElse(taught, hn::MulAdd(share, hn::Sub(value, before), before), before), d, values);
    };
    average(off, distance);
    if (view_.intensity != nullptr) average(hn::GatherIndex(d, view_.intensity, pixel_), intensity);
    const F sum = hn::Min(hn::Add(old, added), constant(view_.max_weight));
    hn::StoreU(hn::IfThenElse(taught, sum, old), d, weight);
  }

private:
  void find_pixels(Mask in_front) {
    const Floats d;
    const Ints di;
    const F u = hn::Add(hn::Div(hn::Mul(constant(view_.fx), x_), z_), constant(view_.cx + 0.5F));
    const F v = hn::Add(hn::Div(hn::Mul(constant(view_.fy), y_), z_), constant(view_.cy + 0.5F));
    const F none = hn::Zero(d);
    const Mask in_row = hn::And(hn::Ge(u, none), hn::Lt(u, constant(static_cast<float>(view_.width))));
    const Mask in_column = hn::And(hn::Ge(v, none), hn::Lt(v, constant(static_cast<float>(view_.height))));
    inside_ = hn::And(in_front, hn::And(in_row, in_column));
    u_ = hn::ConvertTo(di, hn::IfThenElseZero(inside_, u));
    v_ = hn::ConvertTo(di, hn::IfThenElseZero(inside_, v));
    pixel_ = hn::Add(hn::Mul(v_, hn::Set(di, view_.width)), u_);
  }

  F distance_to_plane() const {
    const Floats d;
    const I at = hn::ShiftLeft<2>(pixel_);
    const F last = hn::MulAdd(hn::GatherIndex(d, view_.planes + 2, at), z_, hn::GatherIndex(d, view_.planes + 3, at));
    return hn::MulAdd(hn::GatherIndex(d, view_.planes, at), x_,
                      hn::MulAdd(hn::GatherIndex(d, view_.planes + 1, at), y_, last));
  }

  /// Whether the pixel shows the surface about the voxel, and not another that is in front of it now.
  Mask shows() const {
    const Floats d;
    const Ints di;
    // Half a pixel more, so that rounding does not matter.
    const F cells = constant(1 / static_cast<float>(view_.stride));
    const auto cell_of = [&](I at) {
      return hn::ConvertTo(di, hn::Mul(hn::Add(hn::ConvertTo(d, at), constant(0.5F)), cells));
    };
    const I cell = hn::Add(hn::Mul(cell_of(v_), hn::Set(di, view_.columns)), cell_of(u_));
    const I at = hn::Add(hn::Add(cell, cell), cell);
    const F dx = hn::Sub(hn::GatherIndex(d, view_.places, at), along_);
    const F dy = hn::Sub(hn::GatherIndex(d, view_.places + 1, at), constant(across_[0]));
    const F dz = hn::Sub(hn::GatherIndex(d, view_.places + 2, at), constant(across_[1]));
    const F squared = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
    return hn::Lt(squared, constant(view_.reach * view_.reach)); // false for NaN
  }

  const BentImages& view_;
  F x_, y_, z_; ///< in the camera
  F along_;     ///< in the volume
  std::array<float, 2> across_;
  Mask inside_;
  I u_, v_, pixel_; ///< 0 where there is none
};

void fuse_lanes(const BentImages& view, const BentRow& row, float* distance, float* weight, float* intensity) {
  for (std::size_t begin = 0; begin < kVoxels; begin += hn::Lanes(Floats())) {
    VoxelLanes(view, row, begin).fuse(distance + begin, weight + begin, intensity + begin);
  }
}

} // namespace kinora::tracking::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::tracking {

HWY_EXPORT(fuse_lanes);

void fuse_row(const BentImages& view, const BentRow& row, float* distance, float* weight, float* intensity) {
  HWY_DYNAMIC_DISPATCH(fuse_lanes)(view, row, distance, weight, intensity);
}

} // namespace kinora::tracking
#endif
