// Where an arm or a leg may be whose last place says nothing: hidden ones that appear, fast ones that were overtaken.
#pragma once

#include "tracking/body/body_energy.h"
#include "tracking/body/limbs.h"

namespace kinora::tracking {

/// What the view says of a limb, in patches of its lower and last part's surface, and of points around that no part
/// explains; and, likewise in patches, of its joints that a detector has found elsewhere.
struct LimbVisibility {
  double seen = 0, hidden = 0, free_space = 0;
  double unexplained = 0;
  double detected_elsewhere = 0;
};
LimbVisibility observe_limb(Limb limb, const BodyEvidence& evidence, const BodyState& state,
                            const BodyEnergyConfig& config);

/// What is known of a limb's lower bones in a frame: the picture shows them, something hides them, or they are not
/// where they are thought to be.
enum class LimbHealth { kSeen, kHidden, kLost };
std::string_view name_of(LimbHealth health);
LimbHealth health_of(const LimbVisibility& visibility);

/// Tries other poses of the limb, and takes the best if it has less energy than the state's own: by `margin` at least,
/// and by `jump_cost` for each metre that its end joint is away from where it was.
/// The prior holds for all but the limb's own angles. True if the state was changed.
bool search_limb(Limb limb, const BodyEvidence& evidence, const BodyPrior& prior, const BodyEnergyConfig& config,
                 double margin, double jump_cost, BodyState& state);

} // namespace kinora::tracking
