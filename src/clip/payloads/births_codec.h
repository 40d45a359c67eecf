// The births of a deforming layer's nodes as the bytes of a S_KINORA/BIRTHS payload, and back. docs/container.md
// specifies them.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "clip/coding/allocation_budget.h"
#include "clip/coding/zstd_codec.h"
#include "motion/node_births.h"

namespace kinora::clip {

/// Without loss. Thread-safe. Throws Error(kFailure) if there is not one birth for each node of the graph.
Bytes encode_births(const motion::NodeBirths& births, const motion::DeformationGraph& graph);

/// `frames`: of the clip; a node of that birth is not born in it. Safe for untrusted input; allocates at most what
/// `budget` gives. Thread-safe. Throws Error(kCorruptInput) naming `location`.
motion::NodeBirths decode_births(std::span<const std::byte> payload, const motion::DeformationGraph& graph,
                                 std::size_t frames, const std::string& location, AllocationBudget& budget);

} // namespace kinora::clip
