// Unpacks LZFSE, Apple's compression: blocks of LZ77 with finite-state entropy coding, or of LZVN.
// Source: https://github.com/lzfse/lzfse, which is the format's only description.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace kinora::formats {

/// Exactly `unpacked_bytes`. Throws Error(kCorruptInput), naming `source`, if the bytes are damaged or unpack to
/// another length. Never reads or writes beyond either, and takes time in proportion to both.
std::vector<std::byte> unpack_lzfse(std::span<const std::byte> bytes, std::size_t unpacked_bytes,
                                    const std::string& source);

} // namespace kinora::formats
