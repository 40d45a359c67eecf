// Which part of a clip's file takes how much.
#pragma once

#include <cstdint>
#include <map>

#include "clip/clip_io.h"
#include "container/reader.h"

namespace kinora::clip {

/// `payloads`: what those of each of our tracks take, by Track::id; `sound`: the packets of the clip's sound.
ByteAccount account_of(const container::Reader& reader, const std::map<std::uint16_t, std::size_t>& payloads,
                       std::size_t sound);

} // namespace kinora::clip
