#include "fields/sampling/rim_pixels.h"

#include <cmath>

#include "fields/sampling/pixel_map.h"
#include "fields/sampling/surface_band.h"

namespace kinora::fields {
namespace {

constexpr int kReach = 2; // pixels

} // namespace

RimPixels rim_pixels(const LayerObservations& layer, const StoredFrame& frame, const FieldConfig& config) {
  const PixelStore& pixels = layer.pixels;
  const PixelMap map(pixels, frame);
  std::vector<float> depth_beside(map.size(), 0); // for pixels outside, of the first own one that finds them
  RimPixels rim;
  for (std::size_t i = frame.begin; i < frame.end; ++i) {
    const StoredPixel& own = pixels.pixels()[i];
    if (!layer.is_foreground(own) || !own.depth.is_known()) continue;
    const float depth = own.depth.metres();
    const float past = depth + surface_band(config, depth);
    bool is_rim = false;
    for (const auto& [du, dv] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      for (int k = 1; k <= kReach; ++k) {
        const int u = own.u + k * du;
        const int v = own.v + k * dv;
        const StoredPixel* other = map.at(u, v);
        if (other == nullptr || layer.is_foreground(*other) || !(empty_until(*other) > past)) continue;
        is_rim = true;
        float& beside = depth_beside[map.place(u, v)];
        if (beside == 0) beside = depth;
      }
    }
    if (is_rim) rim.inside.push_back({static_cast<std::uint32_t>(i), depth});
  }
  for (std::size_t i = frame.begin; i < frame.end; ++i) {
    const float beside = depth_beside[map.place(pixels.pixels()[i].u, pixels.pixels()[i].v)];
    if (beside > 0) rim.outside.push_back({static_cast<std::uint32_t>(i), beside});
  }
  return rim;
}

} // namespace kinora::fields
