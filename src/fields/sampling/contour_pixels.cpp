#include "fields/sampling/contour_pixels.h"

#include <cmath>

#include "fields/sampling/pixel_map.h"
#include "fields/sampling/surface_band.h"

namespace kinora::fields {
namespace {

constexpr int kReach = 2; // pixels

} // namespace

ContourPixels contour_pixels(const LayerObservations& layer, const StoredFrame& frame, const FieldConfig& config) {
  const PixelStore& pixels = layer.pixels;
  const PixelMap map(pixels, frame);
  std::vector<float> surface_depth_beside(map.size(), 0); // for pixels outside, of the first own one that finds them
  ContourPixels contour;
  for (std::size_t i = frame.begin; i < frame.end; ++i) {
    const StoredPixel& pixel = pixels.pixels()[i];
    if (!layer.is_foreground(pixel) || !pixel.depth.is_known()) continue;
    const float depth = pixel.depth.metres();
    const float behind_surface = depth + surface_band(config, depth);
    bool is_contour = false;
    for (const auto& [du, dv] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      for (int k = 1; k <= kReach; ++k) {
        const int u = pixel.u + k * du;
        const int v = pixel.v + k * dv;
        const StoredPixel* other = map.at(u, v);
        if (other == nullptr || layer.is_foreground(*other) || !(free_space_until(*other) > behind_surface)) continue;
        is_contour = true;
        float& beside = surface_depth_beside[map.index(u, v)];
        if (beside == 0) beside = depth;
      }
    }
    if (is_contour) contour.inside.push_back({static_cast<std::uint32_t>(i), depth});
  }
  for (std::size_t i = frame.begin; i < frame.end; ++i) {
    const float beside = surface_depth_beside[map.index(pixels.pixels()[i].u, pixels.pixels()[i].v)];
    if (beside > 0) contour.outside.push_back({static_cast<std::uint32_t>(i), beside});
  }
  return contour;
}

} // namespace kinora::fields
