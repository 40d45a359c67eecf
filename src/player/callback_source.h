// Bytes that the caller of include/kinora/player.h fetches.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <kinora/player.h>

#include "container/byte_source.h"

namespace kinora::player {

/// Through a buffer, so that small reads of the container are not paid for one by one. Throws Error(kUsage) if `source`
/// is none, and its read() Error(kFailure) if the caller's function gives nothing.
std::unique_ptr<container::ByteSource> callback_source(const KinoraPlayerSource* source);

} // namespace kinora::player
