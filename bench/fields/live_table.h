// The search of Instant-NVR: canonical voxels near the surface are carried into the live frame; a live voxel keeps one
// that lands in it, and the way back of what lies in the live voxel is that one's.
// Source: Jiang et al., "Instant-NVR", CVPR 2023, section 3.3 (look-up table).
#pragma once

#include <cstdint>
#include <optional>

#include "fields/canonical_search.h"
#include "fields/model/field.h"
#include "motion/bulk_warp.h"

namespace kinora::bench {

class LiveTable : public CanonicalSearch {
public:
  /// The band are the occupied cells, four voxels along each. Both must outlive this.
  LiveTable(const fields::FieldConfig& config, const fields::Occupancy& occupancy);

  void prepare(const Instant& instant) override;
  void find(const std::vector<SearchRay>& rays, Positions& positions) override;

private:
  using Voxel = std::array<std::int16_t, 3>; ///< of the live frame
  Voxel voxel_of(const std::array<float, 3>& live) const;
  std::size_t slot_of(const Voxel& voxel) const; ///< where it is in the table, or would be put

  const fields::FieldConfig* config_;
  const fields::Occupancy* occupancy_;
  float voxels_per_metre_;
  std::vector<std::array<float, 3>> canonical_; // middles of the band's voxels
  std::vector<motion::BulkWarp::WarpedPoint> warped_;
  // A hash table with open addressing; its size is a power of two.
  struct Slot {
    Voxel voxel;
    std::int32_t number; // of the canonical voxel; −1: free
  };
  std::vector<Slot> slots_;
  Eigen::Vector3d canonical_origin_, world_origin_;
};

} // namespace kinora::bench
