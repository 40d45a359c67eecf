// What one view teaches a row of voxels of a bent TsdfVolume, vectorised with Highway and chosen at run time for the
// processor. tests/tracking/bent_row_test.cpp keeps it equal to a plain loop.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace kinora::tracking {

/// A view's images, row by row; all must outlive this.
struct BentImages {
  const float* planes;    ///< four numbers of each pixel, unit normal first: n · x + d in metres
  const float* weights;   ///< of each pixel; 0: no plane
  const float* intensity; ///< of each pixel; nullptr: none
  const float* places;    ///< three numbers of each cell of stride × stride pixels: what it shows, or NaN
  std::int32_t width, height;
  std::int32_t stride;
  std::int32_t columns; ///< cells
  float fx, fy, cx, cy; ///< pixels
  float nearest;        ///< metres before the camera that a voxel must be
  float truncation;     ///< metres
  float reach;          ///< metres, between a voxel and the place that its pixel shows
  float max_weight;
};

/// A brick's row along x.
struct BentRow {
  static constexpr std::size_t kVoxels = 8;
  /// Where the row's first voxel, its middle one and the one after its last are in the camera, metres; and which of the
  /// two halves lies between places that are known.
  std::array<std::array<float, 3>, 3> along;
  std::array<bool, 2> known;
  std::array<float, 3> first; ///< the first voxel's place in the volume, metres
  float voxel;                ///< metres from one to the next
};

/// Averages each voxel that some pixel shows within the truncation with what is measured there. The three arrays have
/// one number for each of the row's voxels. No pixel is read outside the images, wherever the row is.
void fuse_row(const BentImages& view, const BentRow& row, float* distance, float* weight, float* intensity);

} // namespace kinora::tracking
