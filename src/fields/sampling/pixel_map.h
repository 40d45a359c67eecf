// The stored pixels of one frame by their place in its image.
#pragma once

#include <cstdint>
#include <vector>

#include "fields/sampling/pixel_store.h"

namespace kinora::fields {

/// Immutable, thread-safe. `pixels` must outlive the map.
class PixelMap {
public:
  PixelMap(const PixelStore& pixels, const StoredFrame& frame)
      : pixels_(pixels), width_(frame.camera.intrinsics.width), height_(frame.camera.intrinsics.height),
        numbers_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0) {
    for (std::size_t i = frame.begin; i < frame.end; ++i) {
      numbers_[index(pixels.pixels()[i].u, pixels.pixels()[i].v)] = static_cast<std::uint32_t>(i) + 1;
    }
  }

  /// Of the image.
  std::size_t size() const { return numbers_.size(); }
  /// In the image, row by row.
  std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u);
  }
  /// nullptr outside the image, and where none was kept.
  const StoredPixel* at(int u, int v) const {
    if (u < 0 || v < 0 || u >= width_ || v >= height_) return nullptr;
    const std::uint32_t number = numbers_[index(u, v)];
    return number == 0 ? nullptr : &pixels_.pixels()[number - 1];
  }

private:
  const PixelStore& pixels_;
  int width_;
  int height_;
  std::vector<std::uint32_t> numbers_; ///< 1 + index into pixels(); 0: none
};

} // namespace kinora::fields
