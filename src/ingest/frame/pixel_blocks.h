// Square blocks of pixels that become one pixel of a smaller image.
#pragma once

#include <array>
#include <cstdint>

#include "core/image.h"
#include "ingest/frame/reduced_view.h"

namespace kinora::ingest {

/// Metres: mean of the measurements of the block's nearest surface, of those pixels that `is_allowed(u, v)`; 0 without
/// any. The block, `factor` × `factor` pixels from (left, top) on, lies in the image.
template <class Allowed>
float mean_depth(const DepthImage& depth, int left, int top, int factor, const Allowed& is_allowed) {
  float nearest = 0;
  for (int v = top; v < top + factor; ++v) {
    for (int u = left; u < left + factor; ++u) {
      const float z = depth.at(u, v);
      if (z > 0 && (nearest == 0 || z < nearest) && is_allowed(u, v)) nearest = z;
    }
  }
  if (nearest == 0) return 0;
  const auto limit = static_cast<float>(nearest + same_surface_tolerance(nearest));
  float sum = 0;
  float count = 0;
  for (int v = top; v < top + factor; ++v) {
    for (int u = left; u < left + factor; ++u) {
      const float z = depth.at(u, v);
      if (!(z > 0) || z > limit || !is_allowed(u, v)) continue;
      sum += z;
      count += 1;
    }
  }
  return sum / count;
}

/// Of three channels, rounded.
inline void mean_color(const ColorImage& color, int left, int top, int factor, std::uint8_t* mean) {
  std::array<int, 3> sum{};
  for (int v = top; v < top + factor; ++v) {
    const std::uint8_t* pixel = color.pixel(left, v);
    for (int u = 0; u < factor; ++u, pixel += color.channels()) {
      for (std::size_t c = 0; c < 3; ++c) sum[c] += pixel[c];
    }
  }
  const int area = factor * factor;
  for (std::size_t c = 0; c < 3; ++c) mean[c] = static_cast<std::uint8_t>((sum[c] + area / 2) / area);
}

} // namespace kinora::ingest
