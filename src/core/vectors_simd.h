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

constexpr std::size_t kMostLanes = 16;
using Floats = hn::CappedTag<float, kMostLanes>;
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
HWY_INLINE Quat gather4(const float* base, I index) {
  return {gather3(base, index), hn::GatherIndex(Floats(), base + 3, index)};
}

} // namespace kinora::vectors::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
