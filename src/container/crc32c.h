// CRC-32C (Castagnoli): the checksum of every payload.
// Source: RFC 3720 (iSCSI), section 12.1 and appendix B.4; tables "slicing by 8" after Kounavis and Berry, ISCC 2005.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace kinora::container {

/// Checksum of `bytes`, continuing `previous` (0 starts): crc32c(b, crc32c(a)) is that of a followed by b. Thread-safe.
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t previous = 0);

} // namespace kinora::container
