// Where a tile's surface is so smooth that what lies between a few of its pixels need not be marched to.
// Source: Whitted, "An Improved Illumination Model for Shaded Display", CACM 1980 (sampling where corners disagree).
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "fields/rendering/rasterizer.h"
#include "fields/rendering/surface.h"

namespace kinora::fields {

/// A tile's pixels as cells between anchors, which are every third pixel in each direction. Not thread-safe.
class SmoothCells {
public:
  static constexpr int kStep = 3;
  static constexpr int kAnchors = 6; ///< per side
  static_assert((kAnchors - 1) * kStep == TriangleBins::kTile - 1);

  static constexpr bool is_anchor(std::uint32_t pixel) {
    return pixel % TriangleBins::kTile % kStep == 0 && pixel / TriangleBins::kTile % kStep == 0;
  }

  static constexpr std::array<std::uint32_t, kAnchors * kAnchors> anchors() {
    std::array<std::uint32_t, kAnchors * kAnchors> pixels{};
    for (std::uint32_t i = 0; i < pixels.size(); ++i) {
      pixels[i] = kStep * (i / kAnchors * TriangleBins::kTile + i % kAnchors);
    }
    return pixels;
  }

  void clear() { solid_.fill(false); }
  /// An anchor whose ray ends in one opaque surface.
  void set(std::uint32_t pixel, const Surface& surface) {
    const std::size_t i = anchor_of(pixel);
    solid_[i] = true;
    surfaces_[i] = surface;
  }
  /// Finds the cells whose corners lie on one smooth surface: none of their edges bends by more than `tolerance`,
  /// relative to the field's box.
  void find_smooth_cells(float tolerance);
  /// The surface at a pixel that is no anchor, if its cell is smooth.
  std::optional<Surface> at(std::uint32_t pixel) const;

private:
  static std::size_t anchor_of(std::uint32_t pixel) {
    constexpr std::uint32_t kTile = TriangleBins::kTile;
    return pixel / kTile / kStep * kAnchors + pixel % kTile / kStep;
  }
  bool is_straight(std::size_t from, std::size_t stride, std::size_t index, float tolerance) const;

  std::array<bool, kAnchors * kAnchors> solid_{};
  std::array<bool, kAnchors * kAnchors> smooth_{}; // by the cell's first anchor
  std::array<Surface, kAnchors * kAnchors> surfaces_{};
};

} // namespace kinora::fields
