// Where reading can go on behind damaged bytes.
#pragma once

#include <functional>
#include <optional>

#include "container/ebml.h"

namespace kinora::container {

/// True if elements that may stand in a segment or a cluster start at `offset`, three in a row, or up to `limit`, which
/// may cut all but the first.
bool is_plausible_element(ByteSource& source, std::uint64_t offset, std::uint64_t limit);

/// True if a cluster, or another element that stands directly in a segment, seems to start at `offset`: identifier,
/// size and, of a cluster, its first child are as they must be. It may end behind `limit`, where the file was cut.
bool is_plausible_top_level(ByteSource& source, std::uint64_t offset, std::uint64_t limit);

/// The first offset from `from` on at which is_plausible_top_level holds, or at which the element of a block starts for
/// which `is_sound(element)` holds; `limit` if there is none. Reads the source once, in pieces.
std::uint64_t find_sync(ByteSource& source, std::uint64_t from, std::uint64_t limit,
                        const std::function<bool(const Element&)>& is_sound);

} // namespace kinora::container
