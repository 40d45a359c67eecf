// A layer's confidence as the bytes of a S_KINORA/CONFIDENCE payload, and back. docs/container.md specifies them.
#pragma once

#include <span>
#include <string>

#include "clip/coding/allocation_budget.h"
#include "clip/coding/zstd_codec.h"
#include "fields/model/confidence.h"

namespace kinora::clip {

/// Levels are kept exactly; which blocks there are follows from the field's occupancy. The same confidence gives the
/// same bytes. Thread-safe.
Bytes encode_confidence(const fields::Confidence& confidence);

/// `occupancy`: of the field that the payload belongs to. Safe for untrusted input; allocates at most what `budget`
/// gives. Thread-safe. Throws Error(kCorruptInput) naming `location`.
fields::Confidence decode_confidence(std::span<const std::byte> payload, const fields::Occupancy& occupancy,
                                     const std::string& location, AllocationBudget& budget);

/// Bytes that decode_confidence takes from its budget.
std::uint64_t decoding_memory(const fields::Confidence& confidence);

} // namespace kinora::clip
