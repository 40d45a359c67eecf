// Rows of a fixed width in vectors, for *_simd.cpp after <hwy/foreach_target.h>.
#if defined(KINORA_FIELDS_ROW_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_FIELDS_ROW_SIMD_H
#undef KINORA_FIELDS_ROW_SIMD_H
#else
#define KINORA_FIELDS_ROW_SIMD_H
#endif

#include <hwy/highway.h>

namespace kinora::fields::kernels::HWY_NAMESPACE {

/// A row of kWidth floats held in as many vectors as the instruction set needs.
template <int kWidth> struct Row {
  using Tag = hwy::HWY_NAMESPACE::CappedTag<float, kWidth>;
  using Vector = hwy::HWY_NAMESPACE::Vec<Tag>;
  static constexpr int kLanes = static_cast<int>(hwy::HWY_NAMESPACE::MaxLanes(Tag()));
  static constexpr int kVectors = kWidth / kLanes;
};

} // namespace kinora::fields::kernels::HWY_NAMESPACE

#endif
