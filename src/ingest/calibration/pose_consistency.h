// Whether cameras were where they are said to have been: how much of what they show then keeps still.
#pragma once

#include <span>

#include "ingest/frame/reduced_view.h"

namespace kinora::ingest {

/// Share, in [0, 1], of the surface that a view shows which another one, a few views later, shows at the same place in
/// the world: of the same depth, where both measured it, and of the same colour. Only texture tells. A cell of the
/// picture counts by its area in the world, so by the square of its distance: a room is larger than who walks in it.
/// What is out of range is taken for half as far again as the farthest that is measured. 0 if nothing can be told.
/// The same bits for any number of threads.
double photometric_geometric_consistency(std::span<const ReducedView> views);

} // namespace kinora::ingest
