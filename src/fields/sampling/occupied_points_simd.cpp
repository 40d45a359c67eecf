#include "fields/sampling/occupied_points.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/sampling/occupied_points_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::fields::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, 16>;
using Ints = hn::RebindToSigned<Floats>;
using I = hn::Vec<Ints>;
using Mask = hn::Mask<Ints>;

/// 32 bits of an occupancy at a time, as they are in memory.
const std::int32_t* words_of(const Occupancy& occupancy) {
  return reinterpret_cast<const std::int32_t*>(occupancy.words().data());
}

HWY_INLINE I bit_of(const I* cell, std::int32_t resolution) {
  const I side = hn::Set(Ints(), resolution);
  return hn::Add(hn::Mul(hn::Add(hn::Mul(cell[2], side), cell[1]), side), cell[0]);
}

/// Which of the `asked` lanes' bits are set.
HWY_INLINE Mask are_set(const std::int32_t* words, I bit, Mask asked) {
  const Ints di;
  const I word = hn::GatherIndex(di, words, hn::IfThenElseZero(asked, hn::ShiftRight<5>(bit)));
  const I one = hn::Shl(hn::Set(di, 1), hn::And(bit, hn::Set(di, 31)));
  return hn::And(asked, hn::Ne(hn::And(word, one), hn::Zero(di)));
}

// Most points are in empty coarse cells, which the nearest cache tells. What the others need is asked for first, and
// looked at when all have asked.
void find(const Occupancy& coarse, const Occupancy& fine, RayPoints& p) {
  const Floats df;
  const Ints di;
  const auto cells = hn::Set(df, static_cast<float>(fine.resolution()));
  const I last = hn::Set(di, fine.resolution() - 1);
  const I nowhere = hn::Set(di, -1);
  const std::int32_t* fine_words = words_of(fine);
  HWY_ALIGN std::int32_t bits[RayPoints::kMaxPoints][RayPoints::kMaxRays]; // in the fine cells; −1 where empty
  for (std::size_t i = 0; i < p.rays; i += hn::Lanes(di)) {
    const I points = hn::LoadU(di, p.points.data() + i);
    for (std::int32_t k = 0; k < hn::GetLane(hn::MaxOfLanes(di, points)); ++k) {
      const auto depth = hn::LoadU(df, p.depth[static_cast<std::size_t>(k)].data() + i);
      I cell[3];
      I coarse_cell[3];
      for (std::size_t a = 0; a < 3; ++a) {
        const auto at =
            hn::MulAdd(depth, hn::LoadU(df, p.direction[a].data() + i), hn::LoadU(df, p.origin[a].data() + i));
        cell[a] = hn::Min(hn::Max(hn::ConvertTo(di, hn::Mul(at, cells)), hn::Zero(di)), last);
        coarse_cell[a] = hn::ShiftRight<OccupiedPoints::kCoarseShift>(cell[a]);
      }
      const Mask near =
          are_set(words_of(coarse), bit_of(coarse_cell, coarse.resolution()), hn::Lt(hn::Set(di, k), points));
      std::int32_t* row = bits[k] + i;
      hn::Store(hn::IfThenElse(near, bit_of(cell, fine.resolution()), nowhere), di, row);
      for (std::size_t lane = 0; lane < hn::Lanes(di); ++lane) {
        __builtin_prefetch(fine_words + (HWY_MAX(row[lane], 0) >> 5));
      }
    }
  }
  for (std::size_t i = 0; i < p.rays; i += hn::Lanes(di)) {
    const I points = hn::LoadU(di, p.points.data() + i);
    I occupied = hn::Zero(di);
    for (std::int32_t k = 0; k < hn::GetLane(hn::MaxOfLanes(di, points)); ++k) {
      const I bit = hn::Load(di, bits[k] + i);
      const Mask found = are_set(fine_words, bit, hn::Gt(bit, nowhere));
      occupied = hn::Or(occupied, hn::IfThenElseZero(found, hn::Set(di, 1 << k)));
    }
    hn::StoreU(hn::BitCast(hn::RebindToUnsigned<Ints>(), occupied), hn::RebindToUnsigned<Ints>(),
               p.occupied.data() + i);
  }
}

} // namespace kinora::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::fields {
HWY_EXPORT(find);

OccupiedPoints::OccupiedPoints(const Occupancy& occupancy)
    : fine_(occupancy), coarse_(coarsened(occupancy, 1 << kCoarseShift)) {}

void OccupiedPoints::find(RayPoints& points) const { HWY_DYNAMIC_DISPATCH(find)(coarse_, fine_, points); }

} // namespace kinora::fields
#endif
