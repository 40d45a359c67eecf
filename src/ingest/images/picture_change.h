// What pictures say of something that depth takes for moving, where too few views show how noisy depth is.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "core/image.h"

namespace kinora::ingest {

constexpr std::size_t kFewSamples = 6; ///< views; below, little is known of a scene
constexpr int kColorChange = 24;       ///< of 255: two colours are those of different surfaces

/// Largest difference of a channel.
inline int difference(const std::uint8_t* a, const std::uint8_t* b) {
  return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
}

/// Whether colour varies about a pixel, so that what moves there changes the picture.
inline bool has_texture(const ColorImage& color, int u, int v) {
  for (const auto& [x, y] : {std::pair{u - 1, v}, {u + 1, v}, {u, v - 1}, {u, v + 1}})
    if (color.contains(x, y) && difference(color.pixel(u, v), color.pixel(x, y)) > kColorChange) return true;
  return false;
}

/// Pixels with texture of something that depth takes for moving, and those of them where the picture changes too.
struct PictureChange {
  std::size_t textured = 0;
  std::size_t changed = 0;

  void add(bool changes) {
    ++textured;
    changed += changes ? 1 : 0;
  }
  /// Its texture stays where it is: depth is noisier than it should be, and nothing moves.
  bool denies() const { return textured >= 24 && 2 * changed < textured; }
};

} // namespace kinora::ingest
