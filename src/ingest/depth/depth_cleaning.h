// Which depth measurements are safe to fuse.
#pragma once

#include "core/camera.h"
#include "core/image.h"
#include "core/sensor_noise.h"

namespace kinora::ingest {

/// Limits in terms of the sensor's noise (sensor_noise.h) and of the viewing geometry.
struct DepthCleaning {
  double max_jump = 0.03;                           ///< of depth: a larger step to a neighbour is an edge …
  double max_jump_sigmas = kThreeSigmaOfDifference; ///< … but never less than this many standard deviations
  double min_incidence = 0.1745; ///< radians between ray and surface: below, the surface is seen too flat
  int gradient_radius = 4;       ///< pixels to either side from which a surface's slope is estimated
};

/// A copy of `depth` (metres, 0 = none) without
///  - lone pixels, which jump to each of their four neighbours that is measured; where such a pixel (the sensor's salt)
///    stands in a surface that goes on around it, its neighbours are kept,
///  - pixels at a jump to one of the four neighbours, on both sides of it (edges and flying pixels),
///  - surfaces seen at less than `min_incidence`,
///  - and, after that, one pixel along every border to something missing or dropped.
/// The slope of a surface is a least-squares line through the neighbours of the same row and column that no jump
/// separates, so that it stands out of the noise and does not mix surfaces. Thread-safe.
DepthImage clean_depth(const DepthImage& depth, const Intrinsics& intrinsics, const DepthCleaning& limits = {});

} // namespace kinora::ingest
