// Front faces of hulls to pixels: which triangle of which layer each pixel's ray enters, and how deep.
// Source: Olano, Greer, "Triangle Scan Conversion using 2D Homogeneous Coordinates", HWWS 1997: no clipping, also of
// triangles that reach behind the camera.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "fields/rendering/proxy_mesh.h"

namespace kinora::fields {

/// Barycentric coordinates of the point that a pixel's ray meets, times 1 / depth, are rows · (x, y, 1), with (x, y, 1)
/// the pixel's ray in the camera's frame; their sum is 1 / depth.
struct ProxyTriangle {
  std::array<std::array<float, 3>, 3> rows;
  std::array<std::uint32_t, 3> corners;
  std::array<std::int16_t, 4> bounds; ///< pixels: first and last column, first and last row
  std::uint8_t layer;
};

/// Square tiles of a picture with the triangles that may be seen in each.
class TriangleBins {
public:
  static constexpr int kTile = 16; ///< pixels per side

  /// A layer's mesh, at corners in the camera's frame.
  struct Mesh {
    std::span<const Eigen::Vector3f> corners;
    std::span<const ProxyFace> faces;
  };

  /// Of the front faces of all layers; at most 255.
  TriangleBins(const Intrinsics& intrinsics, std::span<const Mesh> layers);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  const ProxyTriangle& triangle(std::uint32_t index) const { return batches_[index / kBatch][index % kBatch]; }
  /// Indices of the tile's triangles, in the order in which they were added.
  std::span<const std::uint32_t> of_tile(int column, int row) const;

private:
  static constexpr std::uint32_t kBatch = 2048; // triangles at most
  void add(std::uint8_t layer, const Mesh& mesh);
  void sort();
  template <class Visit> void for_triangles_and_tiles(const Visit& visit) const;

  Intrinsics intrinsics_;
  int columns_;
  int rows_;
  std::vector<std::vector<ProxyTriangle>> batches_;
  std::vector<std::uint32_t> begin_; // per tile, into members_; one more at the end
  std::vector<std::uint32_t> members_;
};

/// Up to kMax values for each pixel of a tile, nearest first as `<` tells; of more the farthest are dropped. The
/// nearest of all pixels lie together, as most have few.
template <class T, int kMax> class PixelLists {
public:
  static constexpr std::size_t kPixels = TriangleBins::kTile * TriangleBins::kTile;
  static constexpr std::size_t kMaxPerPixel = kMax;

  void clear() { counts_.fill(0); }
  std::size_t count(std::size_t pixel) const { return counts_[pixel]; }
  const T& at(std::size_t pixel, std::size_t number) const { return values_[number * kPixels + pixel]; }
  /// Of equals the one that came first is nearer.
  void insert(std::size_t pixel, const T& value) {
    std::size_t number = counts_[pixel];
    if (number == kMax) {
      if (!(value < at(pixel, number - 1))) return;
      --number;
    } else {
      ++counts_[pixel];
    }
    for (; number > 0 && value < at(pixel, number - 1); --number) {
      values_[number * kPixels + pixel] = at(pixel, number - 1);
    }
    values_[number * kPixels + pixel] = value;
  }

private:
  std::unique_ptr<T[]> values_{new T[kPixels * kMax]}; // without initial values
  std::array<std::uint8_t, kPixels> counts_{};
};

/// Where a pixel's ray enters a hull.
struct Entry {
  float depth;            ///< metres along the optical axis
  std::uint32_t triangle; ///< index into TriangleBins::triangles()
  bool operator<(const Entry& farther) const { return depth < farther.depth; }
};
using Entries = PixelLists<Entry, 8>;

/// Appends the front faces among `faces`, two triangles each.
void add_front(const Intrinsics& intrinsics, const Eigen::Vector3f* corners, std::span<const ProxyFace> faces,
               std::uint8_t layer, std::vector<ProxyTriangle>& out);

/// The rays of a tile's pixels, (x, y, 1) in the camera's frame.
struct TileRays {
  int left, top; ///< its first pixel
  float x, y;    ///< of that
  float dx, dy;  ///< from one pixel to the next
};
TileRays tile_rays(const Intrinsics& intrinsics, int left, int top);

/// Adds the entries of one triangle into the pixels of a tile.
void rasterize(const ProxyTriangle& triangle, std::uint32_t index, const TileRays& rays, Entries& entries);

} // namespace kinora::fields
