// Unpacks the chunks of bags and MCAP files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace kinora::formats {

/// `compression`: "", "none", "lz4" (the frame format), "bz2" or "zstd". Throws Error(kCorruptInput), naming `source`,
/// if the bytes do not unpack to exactly `unpacked_bytes`, or that is absurd for so few bytes: more than 64 MiB and
/// 256 times as many.
std::vector<std::byte> unpack_chunk(const std::string& compression, std::span<const std::byte> bytes,
                                    std::uint64_t unpacked_bytes, const std::string& source);

} // namespace kinora::formats
