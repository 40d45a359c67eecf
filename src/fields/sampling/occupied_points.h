// Which points of rays lie in occupied cells, many at a time, vectorised with Highway.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "fields/sampling/occupancy.h"

namespace kinora::fields {

/// Rays with some points on each, in columns.
struct RayPoints {
  static constexpr std::size_t kMaxRays = 64;
  static constexpr std::size_t kMaxPoints = 12; ///< on each ray
  template <class T> using Column = std::array<T, kMaxRays>;

  std::size_t rays = 0;
  std::array<Column<float>, 3> origin{}, direction{}; ///< FieldRay
  Column<std::int32_t> points{};                      ///< on each ray
  std::array<Column<float>, kMaxPoints> depth{};      ///< of the first points, the second, …; metres
  Column<std::uint32_t> occupied{};                   ///< bit k: whether the ray's k-th point is in an occupied cell

  /// Adds a ray without points.
  void append(const FieldRay& ray) {
    for (std::size_t a = 0; a < 3; ++a) {
      origin[a][rays] = ray.origin[a];
      direction[a][rays] = ray.direction[a];
    }
    ++rays;
  }
};

/// Immutable but for what it refers to, so thread-safe.
class OccupiedPoints {
public:
  static constexpr int kCoarseShift = 2; ///< binary logarithm of the cells along a side of a coarse one

  /// `occupancy` must outlive this, unchanged.
  explicit OccupiedPoints(const Occupancy& occupancy);

  /// Fills in `occupied`. A point outside the box counts as in the nearest cell.
  void find(RayPoints& points) const;

private:
  const Occupancy& fine_;
  Occupancy coarse_;
};

} // namespace kinora::fields
