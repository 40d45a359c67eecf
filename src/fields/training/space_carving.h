// Occupied cells of a trained layer that the capture's cameras see past: what was learnt from pixels with a wrong label
// or a wrong motion, crumbs beside a hand that waves or webs between two parts that touch and part.
#pragma once

#include "fields/model/field.h"
#include "fields/sampling/layer_observations.h"

namespace kinora::fields {

/// Empties cells that clearly more looks of the stored frames (64 of them at most) see past than meet; and parts that
/// hang together with nothing else (cells that share a corner do) if more looks see past them than meet them. What
/// nobody looks at stays, and so does what is thin or really apart, a stick or a hand: it is met where it is. Returns
/// the number of cells emptied. Same bits for any number of threads.
std::size_t carve_free_space(const LayerObservations& layer, Field& field);

} // namespace kinora::fields
