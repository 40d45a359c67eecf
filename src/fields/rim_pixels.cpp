#include "fields/rim_pixels.h"

#include <cmath>

#include "fields/surface_band.h"

namespace kinora::fields {
namespace {

constexpr int kReach = 2; // pixels

/// The frame's pixels by their place.
class PixelMap {
public:
  PixelMap(const PixelStore& pixels, const StoredFrame& frame)
      : width_(frame.camera.intrinsics.width), height_(frame.camera.intrinsics.height),
        stored_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0) {
    for (std::size_t i = frame.begin; i < frame.end; ++i) {
      stored_[place(pixels.pixels()[i].u, pixels.pixels()[i].v)] = static_cast<std::uint32_t>(i) + 1;
    }
  }

  std::size_t size() const { return stored_.size(); }
  bool contains(int u, int v) const { return u >= 0 && v >= 0 && u < width_ && v < height_; }
  std::size_t place(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u);
  }
  /// 1 + index into PixelStore::pixels(); 0: not kept.
  std::uint32_t at(int u, int v) const { return stored_[place(u, v)]; }

private:
  int width_;
  int height_;
  std::vector<std::uint32_t> stored_;
};

} // namespace

RimPixels rim_pixels(const PixelStore& pixels, const StoredFrame& frame, int label, const FieldConfig& config) {
  const PixelMap map(pixels, frame);
  std::vector<float> depth_beside(map.size(), 0); // for pixels outside, of the first own one that finds them
  RimPixels rim;
  for (std::size_t i = frame.begin; i < frame.end; ++i) {
    const StoredPixel& own = pixels.pixels()[i];
    if (own.label != label || own.depth == 0) continue;
    const float depth = std::abs(own.depth);
    const float past = depth + surface_band(config, depth);
    bool is_rim = false;
    for (const auto& [du, dv] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      for (int k = 1; k <= kReach; ++k) {
        const int u = own.u + k * du;
        const int v = own.v + k * dv;
        const std::uint32_t number = map.contains(u, v) ? map.at(u, v) : 0;
        if (number == 0) continue;
        const StoredPixel& other = pixels.pixels()[number - 1];
        if (other.label == label || !(empty_until(other) > past)) continue;
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
