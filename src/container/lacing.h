// Frames that share a block (RFC 9559, section 10.3): remuxers put small packets of sound together.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "container/payload.h"

namespace kinora::container {

/// As the flags of a block say it.
enum class Lacing : std::uint8_t { kNone = 0, kXiph = 1, kFixed = 2, kEbml = 3 };

/// The frames of a block's data, in order; of kNone it is all one. Views into `block`. Empty if the sizes that it tells
/// do not fit it. Thread-safe.
std::vector<std::span<const std::byte>> laced_frames(std::span<const std::byte> block, Lacing lacing);

} // namespace kinora::container
