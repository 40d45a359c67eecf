// Where nodes of a deforming layer were before the tracker found them: a hand that comes out from behind a box was
// behind it. They are followed back from there; what the camera sees past holds them in hiding.
#pragma once

#include "tracking/deforming/model_in_view.h"
#include "tracking/view/frame_history.h"

namespace kinora::tracking {

/// What is hidden lies near to what is seen, and is not it; and it stays where its neighbours would have it unless the
/// camera says otherwise.
struct BackwardSmoothingConfig {
  double extrapolated_share = 0.5; ///< of a point's weights on nodes that were found later: above, it takes part
  double plane_gate = 0.05;        ///< metres, in place of the solver's
  double prior_sigma = 0.007;      ///< metres, likewise: of a place that was guessed from neighbours
};

/// Until they are found, nodes move as their neighbours do, which nobody has seen (NodeTrajectory::is_extrapolated).
/// Follows them back through the frames that are remembered, so that they are where the camera could not see them.
/// `frames`: of the layer `label`, numbered as the trajectory's. Same input, same bits, for any number of threads.
void smooth_backward(const FrameHistory& frames, int label, const CanonicalModel& model, const LayerBinding& binding,
                     const ModelInViewConfig& in_view, const BackwardSmoothingConfig& config,
                     NodeTrajectory& trajectory);

} // namespace kinora::tracking
