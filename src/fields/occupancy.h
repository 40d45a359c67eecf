// Walking along rays through occupied space only.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fields/field.h"

namespace kinora::fields {

/// A ray relative to a field's box: the point at depth z (metres along the optical axis) is origin + z · direction.
struct FieldRay {
  std::array<float, 3> origin;
  std::array<float, 3> direction;
  float metres_per_depth; ///< length of the ray in metres for each metre of depth
};

/// For each cell the Chebyshev distance, in cells, to the nearest occupied one (0 = occupied), capped at kFarthest.
class DistanceField {
public:
  static constexpr int kFarthest = 12;

  DistanceField() = default;
  /// The resolution must be a multiple of 64 (FieldConfig::validate).
  explicit DistanceField(const Occupancy& occupancy);

  int resolution() const { return resolution_; }
  std::uint8_t at(int x, int y, int z) const {
    const std::size_t r = static_cast<std::size_t>(resolution_);
    return distance_[(static_cast<std::size_t>(z) * r + static_cast<std::size_t>(y)) * r + static_cast<std::size_t>(x)];
  }

private:
  int resolution_ = 0;
  std::vector<std::uint8_t> distance_;
};

/// Range of depths in metres.
struct Interval {
  float begin;
  float end;
};

/// The pieces of a ray that lie in occupied cells, from near to far.
class OccupiedIntervals {
public:
  OccupiedIntervals() = default;
  OccupiedIntervals(const DistanceField& distances, const FieldRay& ray, float near_depth, float far_depth);
  /// The next piece; false when there is none left. Neighbouring cells make one piece.
  bool next(Interval& interval);

private:
  // Leaves the cell, or all that is known to be empty around it; the distance to the nearest occupied cell from there.
  int advance();

  const DistanceField* distances_ = nullptr;
  std::array<int, 3> cell_{};        // where the ray is at depth_
  std::array<float, 3> origin_{};    // in cells
  std::array<float, 3> direction_{}; // cells per metre of depth
  std::array<float, 3> inverse_{};
  float depth_ = 0;
  float end_ = 0;
};

inline std::array<float, 3> point_at(const FieldRay& ray, float depth) {
  return {ray.origin[0] + depth * ray.direction[0], ray.origin[1] + depth * ray.direction[1],
          ray.origin[2] + depth * ray.direction[2]};
}

/// The part of the interval that lies in the field's box; begin ≥ end if none does.
Interval in_box(const FieldRay& ray, Interval interval);

/// Whether a position relative to the box lies in an occupied cell; outside the box nothing does.
bool is_occupied(const Occupancy& occupancy, const std::array<float, 3>& position);

/// Marks every cell that the points origin + z · direction of a ray touch for z in the interval. Thread-safe.
void mark_occupied(Occupancy& occupancy, const FieldRay& ray, const Interval& interval);

} // namespace kinora::fields
