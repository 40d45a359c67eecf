// Arms and legs put where a scene wants them.
#pragma once

#include "tracking/body/body_evidence.h"
#include "tracking/body/limbs.h"

namespace kinora::tracking::testing {

/// Angles of one limb.
struct LimbPose {
  Eigen::Quaterniond ball;
  double hinge;
};

/// Of a limb as it is; `angles` as in BodyPose.
LimbPose pose_of(Limb limb, const Angles& angles);

/// Turns a person about the vertical, to his left.
void rotate_root(BodyState& state, double degrees);

/// Of all ways to put the wrist at a place (in the chest's axes, metres from its joint), the most usual one.
LimbPose reaching(Limb arm, const BodyState& state, const Eigen::Vector3d& position);

/// Between two poses, `share` of the way.
void set_limb(Limb limb, const LimbPose& from, const LimbPose& to, double share, BodyState& state);

/// 0 before `begin`, 1 after `length`, smooth in between.
double eased(double frame, double begin, double length);

/// There and back again: up to 1 in `length` frames, `rest` frames there, and back.
double stroke(double frame, double begin, double length, double rest);

} // namespace kinora::tracking::testing
