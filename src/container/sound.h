// Sound as a file of ours has it: a track of a codec that any player understands, and its packets.
#pragma once

#include <optional>
#include <vector>

#include "container/payload.h"

namespace kinora::container {

inline constexpr std::uint16_t kSoundTrack = 0x5300;              ///< what writers call it
inline constexpr const char* kSoundName = "sound";                ///< of a clip
inline constexpr const char* kCaptureSoundName = "capture sound"; ///< of a recording, also of one beside a clip
inline constexpr std::uint64_t kSoundType = 2;                    ///< Matroska's, of a track

/// `track` has a media format with sampling rate and channels; the packets' times never decrease.
struct Sound {
  Track track;
  std::vector<Payload> packets;
};

} // namespace kinora::container
