// Textures sampled in lanes, for *_simd.cpp after <hwy/foreach_target.h>; the same as LayerView::sample_texture().
#if defined(KINORA_TRACKING_TEXTURE_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_TRACKING_TEXTURE_SIMD_H
#undef KINORA_TRACKING_TEXTURE_SIMD_H
#else
#define KINORA_TRACKING_TEXTURE_SIMD_H
#endif

#include "core/vectors_simd.h"
#include "tracking/solver/data_term.h"

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace vectors::HWY_NAMESPACE;

/// One place of a texture for each lane, to be sampled bilinearly.
class TextureLanes {
public:
  /// `u`, `v`: pixels of the view; finite.
  HWY_INLINE TextureLanes(const TextureImage& image, F u, F v) : values_(image.values) {
    const Floats df;
    const Ints di;
    const auto locate = [&](F at, std::int32_t size, F& share, I& second) {
      const F half = constant(0.5F);
      const F in_level = hn::Sub(hn::Mul(hn::Add(at, half), constant(image.scale)), half);
      const F clamped = hn::Min(hn::Max(in_level, zero()), constant(static_cast<float>(size - 1)));
      const I first = hn::Min(hn::ConvertTo(di, clamped), hn::Set(di, size < 2 ? 0 : size - 2));
      share = hn::Sub(clamped, hn::ConvertTo(df, first));
      second = hn::Set(di, size < 2 ? 0 : 1);
      return first;
    };
    I right;
    I below;
    const I x = locate(u, image.width, across_, right);
    const I y = locate(v, image.height, down_, below);
    const I channels = hn::Set(di, 3);
    const I width = hn::Set(di, image.width);
    corners_[0] = hn::Mul(channels, hn::Add(hn::Mul(y, width), x));
    corners_[1] = hn::Add(corners_[0], hn::Mul(channels, right));
    const I row = hn::Mul(channels, hn::Mul(below, width));
    corners_[2] = hn::Add(corners_[0], row);
    corners_[3] = hn::Add(corners_[1], row);
  }

  /// Channel 0: the value; 1, 2: its derivatives by u and v.
  HWY_INLINE F sample(std::ptrdiff_t channel) const {
    const Floats df;
    F at[4];
    for (std::size_t i = 0; i < 4; ++i) at[i] = hn::GatherIndex(df, values_ + channel, corners_[i]);
    const F above = hn::MulAdd(across_, hn::Sub(at[1], at[0]), at[0]);
    const F below = hn::MulAdd(across_, hn::Sub(at[3], at[2]), at[2]);
    return hn::MulAdd(down_, hn::Sub(below, above), above);
  }

private:
  const float* values_;
  I corners_[4]; ///< left above, right above, left below, right below
  F across_, down_;
};

} // namespace kinora::tracking::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
