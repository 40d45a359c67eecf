// Sound between the plugin interface's form and that of files.
#pragma once

#include "container/sound.h"
#include "kinora/plugin.h"

namespace kinora::sound {

/// `sound` has its header; what it points to lives as long as `track`.
void fill(KinoraSound& sound, const container::Track& track);
/// Throws Error(kFailure) where the interface is broken (no codec, absurd rates or sizes).
container::Track track_of(const KinoraSound& sound);

/// `packet` has its header; its bytes live as long as the payload's. `start_time`: where the payload's time counts
/// from, on the clock of frames, seconds.
void fill(KinoraSoundPacket& packet, const container::Payload& payload, double start_time);
/// Throws Error(kFailure) where the interface is broken.
container::Payload payload_of(const KinoraSoundPacket& packet, double start_time);

} // namespace kinora::sound
