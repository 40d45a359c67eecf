// Any sound to Opus, by libavcodec.
#pragma once

#include "container/sound.h"

namespace kinora::sound {

/// See compact. Silence stands where packets are missing.
container::Sound to_opus(const container::Sound& sound);

} // namespace kinora::sound
