// A flat film in a clip's file, for players that know nothing of clips: a track that any of them understands.
#pragma once

#include "container/payload.h"

namespace kinora::container {

inline constexpr std::uint16_t kPreviewTrack = 0x5600; ///< what writers call it
inline constexpr const char* kPreviewName = "preview";
inline constexpr std::uint64_t kVideoType = 1; ///< Matroska's, of a track

/// `track` has a media format with width and height; packets are in the order of decoding, which is that of time.
struct Preview {
  Track track;
  std::vector<Payload> packets;
};

} // namespace kinora::container
