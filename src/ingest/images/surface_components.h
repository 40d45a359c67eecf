// Pieces of surface that hang together in space.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/image.h"

namespace kinora::ingest {

using Mask = Image<std::uint8_t>; ///< 0 or 1 (or what its maker says)

struct SurfaceComponent {
  std::size_t pixels = 0;
  double area = 0; ///< square metres, as seen: each pixel counts z²/(fx·fy)
  Eigen::AlignedBox3d box;
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();

  double extent() const { return pixels == 0 ? 0 : box.diagonal().norm(); }
};

struct SurfaceComponents {
  Image<std::int32_t> map; ///< number of the component at each pixel, −1: none
  std::vector<SurfaceComponent> list;

  /// Number of the one with the largest area; −1 if there is none.
  int largest() const;
};

/// Components of the measured pixels where `mask` is not 0. Two pixels of a row or column hang together if at most
/// `reach` − 1 unmeasured pixels lie between them and their depths differ by no jump. Numbered in the order of their
/// first pixels. Thread-safe.
SurfaceComponents surface_components(const DepthImage& depth, const Mask& mask, const Intrinsics& intrinsics,
                                     int reach = 4);

} // namespace kinora::ingest
