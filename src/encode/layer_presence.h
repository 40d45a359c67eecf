// When a layer is there: what has not come yet, or has gone for good, is no part of a clip's frames.
#pragma once

#include "encode/tracked_label.h"
#include "fields/sampling/pixel_store.h"
#include "motion/presence.h"

namespace kinora::encode {

/// The presence of a label's layer, which moves as `motion` says, in a clip of so many frames. It is away before the
/// first frame that shows a pixel of it, and after the last one, by a few frames less, if it is surely so: no pose is
/// tracked then, and frames of that time see through its surface where its motion has it. What is hidden, out of the
/// picture or not measured is there.
motion::Presence layer_presence(const TrackedLabel& label, const motion::Motion& motion,
                                const fields::PixelStore& pixels, std::size_t frames);

} // namespace kinora::encode
