// One instant of a deforming layer for many points at once: what Warp does for one, in single precision and sixteen at
// a time.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "motion/bulk_warp_kernels.h"
#include "motion/warp.h"

namespace kinora::motion {

/// Immutable, thread-safe. Canonical coordinates are relative to canonical_origin(), those of the world to
/// world_origin(), in metres; a micrometre is kept over some ten metres about them.
class BulkWarp {
public:
  using Ray = kernels::Ray;
  using CanonicalRay = kernels::CanonicalRay;
  using WarpedPoint = kernels::WarpedPoint;

  /// `table` is that of the warp's graph. Throws Error(kFailure) if it is of another, or if the warp is rigid.
  BulkWarp(std::shared_ptr<const InfluenceTable> table, const Warp& warp);

  const Eigen::Vector3d& canonical_origin() const { return table_->origin(); }
  const Eigen::Vector3d& world_origin() const { return world_origin_; }

  /// The way back of each ray's point, to a tenth of a millimetre (a millimetre at folds), and of the ray near it:
  /// half a parabola on either side, straight where that side belongs to another part of the surface. As
  /// Warp::to_canonical, nothing (a point that is not a number) where no way back is found from the nodes that are
  /// nearest. `Ray::start` is overwritten. Writes canonical[i] for rays[i]; the same bits for the same span of rays.
  void to_canonical(std::span<Ray> rays, CanonicalRay* canonical) const;

  /// Writes world[i] for canonical[i].
  void to_world(std::span<const std::array<float, 3>> canonical, WarpedPoint* world) const;

private:
  void index_nodes();
  std::int32_t node_near(const std::array<float, 3>& world) const; ///< −1: none within the influence radius

  std::shared_ptr<const InfluenceTable> table_;
  Warp warp_;
  Eigen::Vector3d world_origin_;
  std::vector<TransformRow> transforms_;
  // A grid over the world: the node that is nearest to each cell's centre.
  std::array<float, 3> low_{};
  float cells_per_metre_ = 1;
  std::array<std::int32_t, 3> cells_{};
  std::vector<std::int32_t> node_of_cell_;
};

} // namespace kinora::motion
