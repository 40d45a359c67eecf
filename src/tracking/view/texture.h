// What a surface looks like, as far as alignment uses it: luminance at several sizes, with its gradient.
#pragma once

#include <array>

#include "core/image.h"

namespace kinora::tracking {

/// One level of the texture pyramid: 3 channels (value, d/du, d/dv), sampled bilinearly.
/// Pixel (u, v) of the view lies at ((u + ½)·scale − ½, (v + ½)·scale − ½) of the level.
struct TextureLevel {
  Image<float> values;
  float scale = 1; ///< pixels of the level to one of the view; 2⁻ˡ unless the texture is finer than the view
};

constexpr int kTextureLevels = 3;
using TexturePyramid = std::array<TextureLevel, kTextureLevels>;

/// Logarithm of luminance of a part of the picture: a surface that turns in the light changes by an offset only.
Image<float> log_luminance(const ColorImage& color, int left, int top, int width, int height);
/// The same of a part as large as the mask, where that is not 0; elsewhere 0.
Image<float> log_luminance(const ColorImage& color, int left, int top, const LabelImage& mask);

/// Where the mask is 0, the mean of the others: what lies beside a layer must not leak into the coarse levels.
void fill_outside(Image<float>& values, const LabelImage& mask);

/// 1 where there is print, or an edge: within two pixels the texture differs from the mean of the 5×5 around by more
/// than light does, which varies slowly over a surface and does not move with it. Elsewhere, and where the mask is not
/// 2, 0.
LabelImage detail_of(const Image<float>& texture, const LabelImage& mask);

/// The finest level has `scale` pixels to one of the view, each other half as many. Gradients are per view pixel.
TexturePyramid texture_pyramid(const Image<float>& values, float scale);

} // namespace kinora::tracking
