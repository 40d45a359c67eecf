// The loops of BulkWarp, vectorised with Highway and chosen at run time for the processor: points in lanes.
// tests/motion/bulk_warp_test.cpp keeps them equal to Warp, which does the same for one point in double precision.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "motion/influence_table.h"

namespace kinora::motion::kernels {

/// A warp, in the coordinates of BulkWarp.
struct NodeMotion {
  const InfluenceTable::Cells* cells;
  const TransformRow* transforms; ///< of each node
};

/// A point in the world and a straight line through it: point + t · direction.
struct Ray {
  std::array<float, 3> point;
  std::array<float, 3> direction; ///< world metres for one unit of t
  float reach;                    ///< the way back is wanted for |t| ≤ reach
  std::int32_t start;             ///< the node that is tried first
};

/// The way back of a ray: point + t · direction + t² · bends[t > 0].
struct CanonicalRay {
  std::array<float, 3> point; ///< not a number where there is no way back
  std::array<float, 3> direction;
  std::array<std::array<float, 3>, 2> curvatures;
  std::array<float, 4> rotation; ///< from there to the world: a unit quaternion x y z w
};

void rays_to_canonical(const NodeMotion& motion, std::span<const Ray> rays, CanonicalRay* canonical);

/// A canonical point in the world and the rotation there.
struct WarpedPoint {
  std::array<float, 3> point;    ///< not a number where no node is near
  std::array<float, 4> rotation; ///< unit quaternion x y z w
};

void points_to_world(const NodeMotion& motion, std::span<const std::array<float, 3>> canonical, WarpedPoint* world);

} // namespace kinora::motion::kernels
