// The inner loop of TsdfVolume::integrate_non_rigid: a brick of voxels between places in the camera, vectorised with
// Highway and chosen at run time for the processor. tests/tracking/tsdf/warped_brick_test.cpp keeps it equal to a plain
// loop.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "motion/skinning/skinned_lanes.h"

namespace kinora::tracking {

/// The images that are fused.
struct FusionImages {
  const float* planes;    ///< four numbers of each pixel, normal first: n · x + d in metres
  const float* weights;   ///< of each pixel; 0: no plane
  const float* intensity; ///< of each pixel; nullptr: none
  const float*
      positions; ///< four numbers of each cell of stride × stride pixels: what it shows, or NaN; and any fourth
  std::int32_t width, height;
  std::int32_t stride;
  std::int32_t columns; ///< cells
  float fx, fy, cx, cy; ///< pixels
  float nearest;        ///< metres before the camera that a voxel must be
  float truncation;     ///< metres
  float reach;          ///< metres, between a voxel and the place that its pixel shows
  float max_weight;
};

/// Points of a brick at which its bending is taken: every fourth voxel along each axis, the next brick's first ones
/// included, x fastest. The other numbers have no meaning.
struct BrickCorners {
  static constexpr std::size_t kAlong = 3;
  static constexpr std::size_t kCount = kAlong * kAlong * kAlong;
  std::array<motion::PointLanes, 2> points;

  float& at(std::size_t axis, std::size_t corner) {
    return points[corner / motion::PointLanes::kPoints].along[axis][corner % motion::PointLanes::kPoints];
  }
  float at(std::size_t axis, std::size_t corner) const {
    return points[corner / motion::PointLanes::kPoints].along[axis][corner % motion::PointLanes::kPoints];
  }
};

struct WarpedBrick {
  static constexpr std::size_t kSide = 8;
  BrickCorners corners;       ///< in the camera, metres; NaN where that is not known
  std::array<float, 3> first; ///< the first voxel's place in the volume, metres
  float voxel;                ///< metres from one to the next
};

/// Averages each voxel that some pixel shows within the truncation with what is measured there. The three arrays have
/// one number for each of the brick's voxels, x fastest. No pixel is read outside the images, wherever the brick is.
void fuse_brick(const FusionImages& view, const WarpedBrick& brick, float* distance, float* weight, float* intensity);

} // namespace kinora::tracking
