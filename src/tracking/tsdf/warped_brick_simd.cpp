#include "tracking/tsdf/warped_brick.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tracking/tsdf/warped_brick_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>
// after highway.h
#include "core/vectors_simd.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace vectors::HWY_NAMESPACE;

constexpr std::size_t kSide = WarpedBrick::kSide;
constexpr std::size_t kVoxels = kSide * kSide * kSide;
constexpr std::size_t kCorners = BrickCorners::kAlong;
constexpr std::size_t kCell = kSide / (kCorners - 1);
static_assert(kMaxLanes <= 2 * kSide); // two rows of one cell at most

/// The corners of a slice of voxels: between those above and below it.
struct Slice {
  std::array<std::array<std::array<float, 3>, kCorners>, kCorners> corner; ///< by y, x and axis

  Slice(const BrickCorners& corners, std::size_t z) {
    const float share = static_cast<float>(z % kCell) / static_cast<float>(kCell);
    for (std::size_t y = 0; y < kCorners; ++y) {
      for (std::size_t x = 0; x < kCorners; ++x) {
        const std::size_t below = (z / kCell * kCorners + y) * kCorners + x;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const float from = corners.at(axis, below);
          corner[y][x][axis] = from + share * (corners.at(axis, below + kCorners * kCorners) - from);
        }
      }
    }
  }
};

/// Voxels side by side, from number `begin` of the brick.
class VoxelLanes {
public:
  VoxelLanes(const FusionImages& view, const WarpedBrick& brick, const Slice& slice, std::size_t begin) : view_(view) {
    const Floats d;
    const Ints di;
    const I number = hn::Add(hn::Iota(di, 0), hn::Set(di, static_cast<std::int32_t>(begin % kSide)));
    const F x = hn::ConvertTo(d, hn::And(number, hn::Set(di, kSide - 1)));
    const std::size_t first_row = begin / kSide % kSide;
    const F row = hn::ConvertTo(d, hn::ShiftRight<3>(number)); // beyond the first
    const auto from_cell = [&](F along, std::size_t cell) {
      return hn::Mul(hn::Sub(along, constant(static_cast<float>(cell * kCell))), constant(1.0F / kCell));
    };
    const std::size_t cell_y = first_row / kCell;
    const F y = hn::Add(row, constant(static_cast<float>(first_row)));
    const F share_y = from_cell(y, cell_y);
    const Mask behind = hn::Ge(x, constant(static_cast<float>(kCell)));
    const F share_x = hn::IfThenElse(behind, from_cell(x, 1), from_cell(x, 0));
    const auto position = [&](std::size_t axis) {
      const auto between = [&](std::size_t corner) {
        const float from = slice.corner[cell_y][corner][axis];
        return hn::MulAdd(share_y, constant(slice.corner[cell_y + 1][corner][axis] - from), constant(from));
      };
      const F middle = between(1);
      const F from = hn::IfThenElse(behind, middle, between(0));
      const F to = hn::IfThenElse(behind, between(2), middle);
      return hn::MulAdd(share_x, hn::Sub(to, from), from);
    };
    camera_ = {position(0), position(1), position(2)};
    const F voxel = constant(brick.voxel);
    const auto slice_number = begin / (kSide * kSide);
    const auto z = static_cast<float>(slice_number);
    volume_ = {hn::MulAdd(x, voxel, constant(brick.first[0])), hn::MulAdd(y, voxel, constant(brick.first[1])),
               constant(brick.first[2] + z * brick.voxel)};
    find_pixels();
  }

  void fuse(float* distance, float* weight, float* intensity) const {
    const Floats d;
    if (hn::AllFalse(d, inside_)) return;
    const F off = distance_to_plane();
    Mask taught = hn::And(inside_, hn::Lt(hn::Abs(off), constant(view_.truncation)));
    if (hn::AllFalse(d, taught)) return;
    taught = hn::And(taught, shows());
    if (hn::AllFalse(d, taught)) return;
    const F trust = hn::GatherIndex(d, view_.weights, pixel_);
    taught = hn::And(taught, hn::Gt(trust, zero()));
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
  void find_pixels() {
    const Ints di;
    const Mask in_front = hn::Gt(camera_.z, constant(view_.nearest)); // false for NaN
    const F inverse = hn::Div(constant(1), camera_.z);
    const F u = hn::MulAdd(hn::Mul(constant(view_.fx), camera_.x), inverse, constant(view_.cx + 0.5F));
    const F v = hn::MulAdd(hn::Mul(constant(view_.fy), camera_.y), inverse, constant(view_.cy + 0.5F));
    const Mask in_row = hn::And(hn::Ge(u, zero()), hn::Lt(u, constant(static_cast<float>(view_.width))));
    const Mask in_column = hn::And(hn::Ge(v, zero()), hn::Lt(v, constant(static_cast<float>(view_.height))));
    inside_ = hn::And(in_front, hn::And(in_row, in_column));
    u_ = hn::ConvertTo(di, hn::IfThenElseZero(inside_, u));
    v_ = hn::ConvertTo(di, hn::IfThenElseZero(inside_, v));
    pixel_ = hn::Add(hn::Mul(v_, hn::Set(di, view_.width)), u_);
  }

  F distance_to_plane() const {
    const Quat plane = gather4(view_.planes, hn::ShiftLeft<2>(pixel_));
    return hn::Add(dot(plane.v, camera_), plane.w);
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
    const Vec3 offset = sub(gather4(view_.positions, hn::ShiftLeft<2>(cell)).v, volume_);
    return hn::Lt(dot(offset, offset), constant(view_.reach * view_.reach)); // false for NaN
  }

  const FusionImages& view_;
  Vec3 camera_, volume_; ///< where the voxels are
  Mask inside_;
  I u_, v_, pixel_; ///< 0 where there is none
};

void fuse_voxels(const FusionImages& view, const WarpedBrick& brick, float* distance, float* weight, float* intensity) {
  std::size_t begin = 0;
  for (std::size_t z = 0; z < kSide; ++z) {
    const Slice slice(brick.corners, z);
    for (const std::size_t end = begin + kVoxels / kSide; begin < end; begin += hn::Lanes(Floats())) {
      VoxelLanes(view, brick, slice, begin).fuse(distance + begin, weight + begin, intensity + begin);
    }
  }
}

} // namespace kinora::tracking::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::tracking {

HWY_EXPORT(fuse_voxels);

void fuse_brick(const FusionImages& view, const WarpedBrick& brick, float* distance, float* weight, float* intensity) {
  HWY_DYNAMIC_DISPATCH(fuse_voxels)(view, brick, distance, weight, intensity);
}

} // namespace kinora::tracking
#endif
