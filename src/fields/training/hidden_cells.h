// Occupied cells of a trained layer that nobody can see: behind its surfaces training finds nothing to change, and what
// is there takes as many bytes, and as long to make ready, as what is seen.
#pragma once

#include "fields/model/field.h"

namespace kinora::fields {

/// Empties cells to which no light comes from outside, at most 0.1 %, whatever way it takes; at least two cells stay
/// behind each surface. What is emptied is enclosed (enclosed_cells()): pictures are the same from everywhere. Returns
/// the number of cells emptied. Same bits for any number of threads.
std::size_t empty_hidden_cells(Field& field);

} // namespace kinora::fields
