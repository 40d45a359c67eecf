// The inside of what a field's occupancy only stores the outside of.
#pragma once

#include "fields/model/field.h"

namespace kinora::fields {

/// Empty cells that no way from outside the box leads to through the sides of empty cells: solid, since nobody can tell
/// and nothing is stored of what cannot be seen. Thread-safe.
Occupancy enclosed_cells(const Occupancy& occupancy);

} // namespace kinora::fields
