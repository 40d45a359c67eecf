// Occupied cells of a trained layer in which nothing is to be seen: where training looked for a surface and found none.
#pragma once

#include "fields/model/field.h"

namespace kinora::fields {

/// Empties cells whose side takes away less than 2 % of the light at each of eight random points. Same bits for any
/// number of threads.
void prune_occupancy(Field& field);

} // namespace kinora::fields
