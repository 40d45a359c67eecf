// The graph of a deforming layer as the private data of its S_KINORA/MOTION track, and back. docs/container.md
// specifies it.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "clip/coding/zstd_codec.h"
#include "motion/motion.h"

namespace kinora::clip {

inline constexpr std::size_t kMaxNodes = 16384;

/// Positions of nodes to half a micrometre for each axis. Thread-safe.
/// Throws Error(kFailure) if it has too many nodes, or one too far away, or a radius that cannot be stored.
Bytes encode_graph(const motion::DeformationGraph& graph);

/// encode_graph(decode_graph(b)) = b for every b that encode_graph wrote. Safe for untrusted input. Thread-safe.
/// Throws Error(kCorruptInput) naming `location`.
std::shared_ptr<const motion::DeformationGraph> decode_graph(std::span<const std::byte> private_data,
                                                             const std::string& location);

} // namespace kinora::clip
