// Which part of a clip's file takes how much.
#pragma once

#include <cstdint>
#include <map>

#include "clip/clip_io.h"
#include "container/reader.h"

namespace kinora::clip {

/// `payloads`: what those of each of our tracks take, by Track::id; `media`: what the blocks of other tracks take, by
/// their place in Reader::tracks().
ByteAccount account_of(const container::Reader& reader, const std::map<std::uint16_t, std::size_t>& payloads,
                       const std::map<std::size_t, std::size_t>& media);

} // namespace kinora::clip
