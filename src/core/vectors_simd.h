// Points and quaternions in lanes, for *_simd.cpp after <hwy/foreach_target.h>: compiled once for each instruction set,
// as Highway's own -inl.h files are. Functions of Vec3 and Quat are found by their arguments.
#if defined(KINORA_CORE_VECTORS_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_CORE_VECTORS_SIMD_H
#undef KINORA_CORE_VECTORS_SIMD_H
#else
#define KINORA_CORE_VECTORS_SIMD_H
#endif

#include <cstddef>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::vectors::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kMaxLanes = 16;
using Floats = hn::CappedTag<float, kMaxLanes>;
using Ints = hn::RebindToSigned<Floats>;
using F = hn::Vec<Floats>;
using I = hn::Vec<Ints>;
using Mask = hn::Mask<Floats>;

struct Vec3 {
  F x, y, z;
};

struct Quat {
  Vec3 v;
  F w;
};

HWY_INLINE F zero() { return hn::Zero(Floats()); }
HWY_INLINE F constant(float value) { return hn::Set(Floats(), value); }
HWY_INLINE Vec3 add(const Vec3& a, const Vec3& b) { return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)}; }
HWY_INLINE Vec3 sub(const Vec3& a, const Vec3& b) { return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)}; }
HWY_INLINE Vec3 mul(F s, const Vec3& a) { return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)}; }
/// s · a + b
HWY_INLINE Vec3 mul_add(F s, const Vec3& a, const Vec3& b) {
  return {hn::MulAdd(s, a.x, b.x), hn::MulAdd(s, a.y, b.y), hn::MulAdd(s, a.z, b.z)};
}
HWY_INLINE Quat mul(F s, const Quat& a) { return {mul(s, a.v), hn::Mul(s, a.w)}; }
HWY_INLINE Quat mul_add(F s, const Quat& a, const Quat& b) { return {mul_add(s, a.v, b.v), hn::MulAdd(s, a.w, b.w)}; }
HWY_INLINE F dot(const Vec3& a, const Vec3& b) { return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z))); }
HWY_INLINE F dot(const Quat& a, const Quat& b) { return hn::MulAdd(a.w, b.w, dot(a.v, b.v)); }
HWY_INLINE Vec3 cross(const Vec3& a, const Vec3& b) {
  return {hn::NegMulAdd(a.z, b.y, hn::Mul(a.y, b.z)), hn::NegMulAdd(a.x, b.z, hn::Mul(a.z, b.x)),
          hn::NegMulAdd(a.y, b.x, hn::Mul(a.x, b.y))};
}
HWY_INLINE Vec3 choose(Mask m, const Vec3& yes, const Vec3& no) {
  return {hn::IfThenElse(m, yes.x, no.x), hn::IfThenElse(m, yes.y, no.y), hn::IfThenElse(m, yes.z, no.z)};
}

/// `index` counts floats.
HWY_INLINE Vec3 gather3(const float* base, I index) {
  const Floats df;
  return {hn::GatherIndex(df, base, index), hn::GatherIndex(df, base + 1, index), hn::GatherIndex(df, base + 2, index)};
}

#if HWY_TARGET == HWY_SCALAR
template <class RowOf> HWY_INLINE Quat load_rows(const RowOf& row_of) {
  const float* row = row_of(0);
  const Floats df;
  return {{hn::Set(df, row[0]), hn::Set(df, row[1]), hn::Set(df, row[2])}, hn::Set(df, row[3])};
}
#else
/// The rows of the lanes `first`, `first` + 4, `first` + 8, …, one after the other.
template <std::size_t kLanes, class RowOf>
HWY_INLINE hn::Vec<hn::FixedTag<float, kLanes>> every_fourth_row(const RowOf& row_of, std::size_t first) {
  const hn::FixedTag<float, kLanes> d;
  if constexpr (kLanes == 4) {
    return hn::LoadU(d, row_of(first));
  } else {
    return hn::Combine(d, every_fourth_row<kLanes / 2>(row_of, first + kLanes / 2),
                       every_fourth_row<kLanes / 2>(row_of, first));
  }
}

/// The four floats at row_of(lane) for each lane. Whole rows are loaded and transposed: several times as fast as four
/// gathers.
template <class RowOf> HWY_INLINE Quat load_rows(const RowOf& row_of) {
  const Floats df;
  const hn::RepartitionToWide<Floats> pairs;
  constexpr std::size_t kLanes = hn::MaxLanes(Floats());
  const F a = every_fourth_row<kLanes>(row_of, 0);
  const F b = every_fourth_row<kLanes>(row_of, 1);
  const F c = every_fourth_row<kLanes>(row_of, 2);
  const F d = every_fourth_row<kLanes>(row_of, 3);
  const auto xy_first = hn::BitCast(pairs, hn::InterleaveLower(df, a, b));
  const auto xy_second = hn::BitCast(pairs, hn::InterleaveLower(df, c, d));
  const auto zw_first = hn::BitCast(pairs, hn::InterleaveUpper(df, a, b));
  const auto zw_second = hn::BitCast(pairs, hn::InterleaveUpper(df, c, d));
  return {{hn::BitCast(df, hn::InterleaveLower(pairs, xy_first, xy_second)),
           hn::BitCast(df, hn::InterleaveUpper(pairs, xy_first, xy_second)),
           hn::BitCast(df, hn::InterleaveLower(pairs, zw_first, zw_second))},
          hn::BitCast(df, hn::InterleaveUpper(pairs, zw_first, zw_second))};
}
#endif

/// Which of `count` items each lane takes: beyond the last, the last again.
HWY_INLINE std::size_t item_of(std::size_t lane, std::size_t count) { return lane < count ? lane : count - 1; }

/// Stores x, y, z, w of the first `count` lanes at row_of(lane).
template <class RowOf> HWY_INLINE void store_rows(const Quat& q, std::size_t count, const RowOf& row_of) {
  const Floats df;
#if HWY_TARGET == HWY_SCALAR
  HWY_ALIGN float rows[1][4] = {{hn::GetLane(q.v.x), hn::GetLane(q.v.y), hn::GetLane(q.v.z), hn::GetLane(q.w)}};
  (void)df;
#else
  const hn::RepartitionToWide<Floats> pairs;
  HWY_ALIGN float rows[4][hn::MaxLanes(Floats())]; // each with the lanes that are so many beyond a multiple of four
  const auto xy_first = hn::BitCast(pairs, hn::InterleaveLower(df, q.v.x, q.v.y));
  const auto xy_second = hn::BitCast(pairs, hn::InterleaveUpper(df, q.v.x, q.v.y));
  const auto zw_first = hn::BitCast(pairs, hn::InterleaveLower(df, q.v.z, q.w));
  const auto zw_second = hn::BitCast(pairs, hn::InterleaveUpper(df, q.v.z, q.w));
  hn::Store(hn::BitCast(df, hn::InterleaveLower(pairs, xy_first, zw_first)), df, rows[0]);
  hn::Store(hn::BitCast(df, hn::InterleaveUpper(pairs, xy_first, zw_first)), df, rows[1]);
  hn::Store(hn::BitCast(df, hn::InterleaveLower(pairs, xy_second, zw_second)), df, rows[2]);
  hn::Store(hn::BitCast(df, hn::InterleaveUpper(pairs, xy_second, zw_second)), df, rows[3]);
#endif
  for (std::size_t lane = 0; lane < count; ++lane) {
    __builtin_memcpy(row_of(lane), rows[lane % 4] + (lane & ~std::size_t{3}), 4 * sizeof(float));
  }
}

/// `index` counts floats.
HWY_INLINE Quat gather4(const float* base, I index) {
  HWY_ALIGN std::int32_t rows[hn::MaxLanes(Floats())];
  hn::Store(index, Ints(), rows);
  return load_rows([&](std::size_t lane) { return base + rows[lane]; });
}

} // namespace kinora::vectors::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
