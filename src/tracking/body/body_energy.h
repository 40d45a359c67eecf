// How badly a posed body explains one view, and which way it would explain it better.
// Source: Tagliasacchi et al., "Robust Articulated-ICP for Real-Time Hand Tracking", SGP 2015 (points to the nearest
// part, silhouette, priors).
#pragma once

#include "tracking/body/body_evidence.h"
#include "tracking/body/body_prior.h"

namespace kinora::tracking {

/// Same bits for any number of threads. Finite for finite input, also without any evidence.
BodyEquations evaluate(const BodyEvidence& evidence, const BodyState& state, const BodyPrior& prior,
                       const BodyEnergyConfig& config);

/// Improves the state by at most `iterations` damped Gauss–Newton steps; its energy after them, but for a last one
/// below 2 mm and 2 mrad. `with_shape`: measures may change too.
double minimise(const BodyEvidence& evidence, const BodyPrior& prior, const BodyEnergyConfig& config, int iterations,
                bool with_shape, BodyState& state);

} // namespace kinora::tracking
