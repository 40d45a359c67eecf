// Size and pose of a person from one view, without an idea of either.
#pragma once

#include <span>

#include "tracking/body/body_energy.h"

namespace kinora::tracking {

struct BodyFit {
  BodyState state; ///< in the camera
  double energy;
};

/// Tries eight sides the person may turn to the camera, two sizes, and limbs in many poses; the one of least energy.
/// Where a detector has found joints this is done with them and without, and the first is taken unless the view alone
/// clearly speaks against it: left and right may have been mistaken for each other.
/// `prior` says what is known of the shape; its pose is not used. The view must not be empty.
/// Finite for every view; same bits for any number of threads.
/// `earlier`: poses in the camera that are tried as well.
BodyFit fit_body(const LayerView& view, const BodyPrior& prior, const BodyEnergyConfig& config,
                 std::span<const BodyPose> earlier = {});

} // namespace kinora::tracking
