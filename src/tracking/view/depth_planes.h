// The plane that the neighbourhood of each depth pixel lies on: normals, smoothed depth and a weight for fusion.
#pragma once

#include "core/camera.h"
#include "core/image.h"

namespace kinora::tracking {

/// One oriented plane per pixel, in the camera's frame.
struct DepthPlanes {
  /// 4 channels (n, offset): n·x + offset is the signed distance of x (metres) to the plane, positive on the camera's
  /// side; |n| = 1. All zero where there is no plane.
  Image<float> planes;
  /// Fusion weight in [0, 1.6]: cosine of the viewing angle × (σ(1 m)/σ(z))²; 0 where there is no plane.
  Image<float> weights;
};

/// Least-squares planes over windows of 5×5 pixels. A plane is an affine function of the pixel in inverse depth, so the
/// fit is linear; neighbours beyond the noise (4σ plus the slope of a grazing surface) are left out, and fewer than 6
/// give no plane. `allowed` (non-zero = may be used; empty = all pixels) must have the size of `depth`; depths that are
/// not positive and finite are ignored. Throws Error(kFailure) if sizes differ. Same bits for any number of threads.
DepthPlanes fit_depth_planes(const DepthImage& depth, const Intrinsics& intrinsics, const LabelImage& allowed = {});

} // namespace kinora::tracking
