// Where nodes of a deforming layer were before the tracker found them: a hand that comes out from behind a box was
// behind it. They are followed back from there; what the camera sees past holds them in hiding.
#pragma once

#include "tracking/frame_memory.h"
#include "tracking/model_in_view.h"

namespace kinora::tracking {

/// Until they are found, nodes move as their neighbours do, which nobody has seen (NodeTrajectory::is_guess). Follows
/// them back through the frames that are remembered, so that they are where the camera could not see them. `frames`: of
/// the layer `label`, numbered as the trajectory's. Same input, same bits, for any number of threads.
void smooth_backward(const FrameMemory& frames, int label, const CanonicalModel& model, const LayerBinding& binding,
                     const ModelInViewConfig& config, NodeTrajectory& trajectory);

} // namespace kinora::tracking
