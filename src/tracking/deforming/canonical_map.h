// Where the pixels of a view are in a layer's canonical space.
#pragma once

#include <span>

#include "motion/skinning/blended_motion.h"
#include "tracking/tsdf/tsdf.h"
#include "tracking/view/layer_view.h"

namespace kinora::tracking {

/// Canonical places (relative to the origin) of every fourth pixel of the view in each direction, each carried back by
/// the motion of the model's surface that is seen nearest to it. Pixels with no surface of a like normal within
/// `reach` metres show nothing. `states`: canonical to camera; `skin`: influence of each surface point.
TsdfVolume::CanonicalMap find_canonical_map(const LayerView& view, std::span<const SurfacePoint> surface,
                                            std::span<const motion::Influence> skin, const motion::NodeStates& states,
                                            double reach);

} // namespace kinora::tracking
