// Zstandard with bounds for untrusted input. Source: RFC 8878.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace kinora::clip {

using Bytes = std::vector<std::byte>;

/// One frame that knows its decompressed size. The same bytes give the same frame (same libzstd). Thread-safe.
Bytes compress(std::span<const std::byte> bytes);

/// The reverse, into exactly `size` bytes, which are allocated only if the frame announces that many.
/// Throws Error(kCorruptInput) naming `location` if it is anything but one frame of that size. Thread-safe.
Bytes decompress(std::span<const std::byte> frame, std::size_t size, const std::string& location);

/// What the frame says of itself, not believed yet. Throws Error(kCorruptInput) if it does not say.
std::uint64_t decompressed_size(std::span<const std::byte> frame, const std::string& location);

} // namespace kinora::clip
