// What stands around a payload's bytes inside a Matroska block, around a track's private data inside CodecPrivate, and
// beside an attachment: identity, time and checksum that remuxing keeps. docs/container.md specifies them.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "container/payload.h"

namespace kinora::container {

inline constexpr std::size_t kEnvelopeBytes = 16;
inline constexpr std::size_t kPrivateHeaderBytes = 12;

/// Envelope and bytes. Throws Error(kFailure) if the time is negative.
Bytes wrap_payload(std::uint16_t track, std::int64_t time_ns, bool key, std::span<const std::byte> bytes);

/// The reverse, for a block of track `track`; offset and stored_bytes are left to the caller.
/// Throws Error(kCorruptInput) naming `location`: too short, unknown version, another track, wrong checksum.
Payload unwrap_payload(std::uint16_t track, std::span<const std::byte> block, const std::string& location);

/// CodecPrivate of a track of ours.
Bytes wrap_private(const Track& track);

/// Fills `track`'s id and private data. Throws Error(kCorruptInput) naming `location`.
void unwrap_private(std::span<const std::byte> codec_private, Track& track, const std::string& location);

/// `description` with the checksum of an attachment's bytes behind it: "… crc32c:89abcdef".
std::string with_checksum(const std::string& description, std::span<const std::byte> bytes);

/// The checksum at the end of a description, if there is one; `description` loses it.
std::optional<std::uint32_t> take_checksum(std::string& description);

} // namespace kinora::container
