// The joints of a layer's skeleton as the bytes of a S_KINORA/JOINTS payload, and back. docs/container.md specifies
// them.
#pragma once

#include <span>
#include <string>

#include "clip/coding/allocation_budget.h"
#include "clip/coding/zstd_codec.h"
#include "motion/joint_paths.h"

namespace kinora::clip {

/// Places are kept to 1 mm for each axis; what was read is written as the same bytes again. Thread-safe. Throws
/// Error(kFailure) if the joints cannot be stored: too many, badly named, too far away, or not one place for each.
Bytes encode_joints(const motion::JointPaths& joints);

/// `frames`: of the clip. Safe for untrusted input; allocates at most what `budget` gives. Thread-safe. Throws
/// Error(kCorruptInput) naming `location`.
motion::JointPaths decode_joints(std::span<const std::byte> payload, std::size_t frames, const std::string& location,
                                 AllocationBudget& budget);

/// Bytes that decode_joints takes from its budget.
std::uint64_t decoding_memory(const motion::JointPaths& joints);

} // namespace kinora::clip
