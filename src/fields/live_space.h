// The space around a deforming layer at one instant: where its occupied canonical cells are now, and for each such
// place the way back. Built once per frame, it makes the inverse warp of a sample one look-up and one affine map.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fields/field.h"
#include "fields/occupancy.h"
#include "tracking/warp.h"

namespace kinora::fields {

/// Immutable, thread-safe.
class LiveSpace {
public:
  /// `occupancy` is in canonical space. Uses all threads; same bits for any number of them.
  LiveSpace(const FieldConfig& config, const Occupancy& occupancy, const tracking::Warp& warp);

  /// World-space cube that the live cells fill; rays are relative to it. Its cells are those of `distances()`.
  const FieldBox& box() const { return box_; }
  /// Walks only through live occupied cells.
  const DistanceField& distances() const { return distances_; }

  /// canonical = linear · live + offset, both relative to their boxes.
  struct Map {
    std::array<float, 9> linear; ///< row by row
    std::array<float, 3> offset;

    std::array<float, 3> apply(const std::array<float, 3>& live) const;
  };
  /// The map of the cell that holds a point of live space; nullptr where the layer is not.
  const Map* map_at(const std::array<float, 3>& live) const;

private:
  Occupancy mark_cells(const FieldConfig& config, const Occupancy& occupancy, const tracking::Warp& warp);
  Occupancy fit_maps(const FieldConfig& config, const Occupancy& live, const tracking::Warp& warp);

  FieldBox box_;
  DistanceField distances_;
  std::vector<std::uint32_t> cell_map_; // per cell, 1 + index into maps_; 0: nothing
  std::vector<Map> maps_;
};

/// A ray of live space carried into canonical space by a map.
FieldRay to_canonical(const LiveSpace::Map& map, const FieldRay& live);

} // namespace kinora::fields
