// When a layer is shown.
#pragma once

#include "clip/clip.h"

namespace kinora::clip {

/// At which of a clip's `frames` frames a layer is drawn and exported: not where the file says that it is away, nor,
/// if it moves, before it was first seen (motion/first_frame.h). `birth`: of the part of it that is asked for.
motion::Presence shown_frames(const Layer& layer, std::size_t frames, std::size_t birth = 0);

} // namespace kinora::clip
