// Occupied space, and where rays are in it.
#pragma once

#include <array>

#include "fields/model/field.h"

namespace kinora::fields {

/// A ray relative to a field's box: the point at depth z (metres along the optical axis) is origin + z · direction.
struct FieldRay {
  std::array<float, 3> origin;
  std::array<float, 3> direction;
  float metres_per_depth; ///< length of the ray in metres for each metre of depth
};

/// Range of depths in metres.
struct Interval {
  float begin;
  float end;
};

inline std::array<float, 3> point_at(const FieldRay& ray, float depth) {
  return {ray.origin[0] + depth * ray.direction[0], ray.origin[1] + depth * ray.direction[1],
          ray.origin[2] + depth * ray.direction[2]};
}

/// The part of the interval that lies in the field's box; begin ≥ end if none does.
Interval in_box(const FieldRay& ray, Interval interval);

/// Marks the cells that a ray touches in an interval of depths, in steps of half a cell: the corners of some are
/// missed. Thread-safe.
void mark_occupied(Occupancy& occupancy, const FieldRay& ray, const Interval& interval);

} // namespace kinora::fields
