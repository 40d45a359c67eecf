// Front faces of hulls to pixels: which triangle of which layer each pixel's ray enters, and how deep.
// Source: Olano, Greer, "Triangle Scan Conversion using 2D Homogeneous Coordinates", HWWS 1997: no clipping, also of
// triangles that reach behind the camera.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "fields/brick_hull.h"

namespace kinora::fields {

/// Barycentric coordinates of the point that a pixel's ray meets, times 1 / depth, are rows · (x, y, 1), with (x, y, 1)
/// the pixel's ray in the camera's frame; their sum is 1 / depth.
struct HullTriangle {
  std::array<std::array<float, 3>, 3> rows;
  std::array<std::uint32_t, 3> corners;
  std::array<std::int16_t, 4> bounds; ///< pixels: first and last column, first and last row
  std::uint8_t layer;
};

/// Square tiles of a picture with the triangles that may be seen in each.
class TriangleBins {
public:
  static constexpr int kTile = 16; ///< pixels per side

  explicit TriangleBins(const Intrinsics& intrinsics);

  /// Adds the front faces of a layer, at corners in the camera's frame; layers in ascending order.
  void add(std::uint8_t layer, std::span<const Eigen::Vector3f> corners, std::span<const HullFace> faces);
  /// To be called once, after all layers.
  void sort();

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  const std::vector<HullTriangle>& triangles() const { return triangles_; }
  /// Indices of the tile's triangles, in the order in which they were added.
  std::span<const std::uint32_t> of_tile(int column, int row) const;

private:
  bool make(const std::array<const Eigen::Vector3f*, 3>& corners, HullTriangle& triangle) const;

  Intrinsics intrinsics_;
  int columns_;
  int rows_;
  std::vector<HullTriangle> triangles_;
  std::vector<std::uint32_t> begin_; // per tile, into members_; one more at the end
  std::vector<std::uint32_t> members_;
};

/// Up to kMost values for each pixel of a tile, nearest first; of more the farthest are dropped.
template <class T, int kMost> class PixelLists {
public:
  static constexpr std::size_t kPixels = TriangleBins::kTile * TriangleBins::kTile;

  void clear() { counts_.fill(0); }
  std::span<const T> of(std::size_t pixel) const { return {&values_[pixel * kMost], counts_[pixel]}; }
  /// T has a member `depth`.
  void insert(std::size_t pixel, const T& value) {
    T* list = &values_[pixel * kMost];
    std::size_t at = counts_[pixel];
    if (at == kMost) {
      if (!(value.depth < list[at - 1].depth)) return;
      --at;
    } else {
      ++counts_[pixel];
    }
    for (; at > 0 && value.depth < list[at - 1].depth; --at) list[at] = list[at - 1];
    list[at] = value;
  }

private:
  std::vector<T> values_ = std::vector<T>(kPixels * kMost);
  std::array<std::uint8_t, kPixels> counts_{};
};

/// Where a pixel's ray enters a hull.
struct Entry {
  float depth;            ///< metres along the optical axis
  std::uint32_t triangle; ///< index into TriangleBins::triangles()
};
using Entries = PixelLists<Entry, 8>;

/// Adds the entries of one triangle into the pixels of a tile whose first pixel is (left, top).
void rasterize(const HullTriangle& triangle, std::uint32_t index, const Intrinsics& intrinsics, int left, int top,
               Entries& entries);

} // namespace kinora::fields
