// The large planes of a scene: floor, table, walls.
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "core/image.h"

namespace kinora::ingest {

/// Points p with normal·p = offset. The normal has unit length and points to the camera's side: the camera's own
/// centre lies at distance −offset in its direction, so that offset < 0 and what is in front has normal·p > offset.
struct Plane {
  Eigen::Vector3d normal;
  double offset;

  double distance(const Eigen::Vector3d& point) const { return normal.dot(point) - offset; }
};

struct PlaneSearch {
  double min_share = 0.08; ///< of the measured pixels must lie on a plane
  double min_extent = 0.5; ///< metres: diagonal of what lies on it
  /// Root mean square distance, in same_surface_tolerances, unless the plane is wide both ways: noise gives 0.33, a
  /// slab of something bent 0.58. Sensors bend wide walls.
  double max_roughness = 0.45;
  double wide = 1.0; ///< metres
  int max_planes = 4;
  std::uint64_t seed = 1;
};

/// The planes that hold most measured pixels, the largest first (RANSAC: Fischler and Bolles, 1981; three points of one
/// neighbourhood per trial, then least squares). A point lies on a plane within same_surface_tolerance. Thread-safe.
std::vector<Plane> find_planes(const DepthImage& depth, const Intrinsics& intrinsics, const PlaneSearch& search = {});

} // namespace kinora::ingest
