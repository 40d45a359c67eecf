// Which entry of a level's table belongs to a vertex of its grid.
// Source: Teschner et al., "Optimized Spatial Hashing for Collision Detection of Deformable Objects", VMV 2003; Müller
// et al., "Instant Neural Graphics Primitives", ACM TOG 41(4), 2022, eq. 4.
#pragma once

#include <cstdint>

#include "fields/model/field.h"

namespace kinora::fields {

/// Entry of vertex (x, y, z) within its level.
inline std::uint32_t vertex_entry(const GridLevel& level, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  if (level.hashed) return (x ^ (y * 2654435761U) ^ (z * 805459861U)) & (level.size - 1);
  const std::uint32_t n = static_cast<std::uint32_t>(level.resolution) + 1;
  return (z * n + y) * n + x;
}

} // namespace kinora::fields
