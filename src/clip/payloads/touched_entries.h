// Which entries of a field's table can matter: those that some point in an occupied cell interpolates.
#pragma once

#include <cstdint>
#include <vector>

#include "fields/model/field.h"

namespace kinora::clip {

/// The touched entries of a level in increasing order, counted from the level's first entry.
/// A grid vertex (x, y, z) of a level of resolution N is touched if some occupied cell (i, j, k) of the occupancy of
/// resolution R has floor(i·N/R) ≤ x ≤ floor((i+1)·N/R) + 1 and the like for y and z. All entries of a level count as
/// touched where this would visit more than kMaxVisits vertices (occupied cells times (floor(N/R) + 3)³). Both sides
/// derive the same list, so that it is not stored. Thread-safe.
std::vector<std::uint32_t> touched_entries(const fields::GridLevel& level, const fields::Occupancy& occupancy);
/// The same of each level.
std::vector<std::vector<std::uint32_t>> touched_entries(const fields::FieldConfig& config,
                                                        const fields::Occupancy& occupancy);

inline constexpr std::uint64_t kMaxVisits = std::uint64_t{1} << 26;

} // namespace kinora::clip
