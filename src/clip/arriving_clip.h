// A clip whose file has come in part, in one piece or in several.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "clip/clip.h"
#include "container/byte_source.h"

namespace kinora::clip {

/// What there is of it, beside the clip.
struct Arrival {
  std::vector<std::string> missing; ///< as read_whole_parts says it
  std::size_t layers = 0;           ///< that the file says it has; the clip has those that have come
  std::vector<double> times; ///< seconds, of all frames that the file says it has; the clip's are the first of them
  std::vector<bool> there;   ///< one for each: everything that moves and has come at all has come for it
};

/// As read_whole_parts (clip_io.h), of the bytes that have come, one piece behind the other: each but the first begins
/// with a cluster. Safe for untrusted input. Throws as read_whole_parts.
Clip read_arriving(std::unique_ptr<container::ByteSource> source, Arrival& arrival);

} // namespace kinora::clip
