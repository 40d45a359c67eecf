// How people hold their arms and legs: what is expected of a limb that nothing shows.
// Sources: Bogo et al., "Keep it SMPL", ECCV 2016, eq. 5 (a mixture of Gaussians fitted to motion capture; theirs
// counts its nearest part alone); the CMU Graphics Lab Motion Capture Database. `fit_pose_prior.py` makes the table.
#pragma once

#include "tracking/body/limbs.h"

namespace kinora::tracking {

struct PosePriorConfig {
  double weight = 1;  ///< of the energy; less lets hidden limbs go where they were led, and a cloth pass for a person
  double trust = 0.5; ///< probability that a limb is held as in the motions that the table was fitted to; else it is
                      ///< held in any way about its joints' usual angles (skeleton.h): no pose costs much more
  double limit_sigma = 0.03; ///< radians beyond a joint's limit
};

/// A limb's ball joint and hinge, as in the pose's angles.
constexpr int kLimbAngles = 4;
using LimbAngles = Eigen::Matrix<double, kLimbAngles, 1>;
LimbAngles limb_angles(Limb limb, const Angles& angles);

/// Minus twice the logarithm of a probability, at least 0, like a sum of squares in units of their deviations: half its
/// gradient, and a positive matrix in place of half its second derivatives that no step overshoots with.
struct PosePrior {
  double energy;
  LimbAngles gradient;
  Eigen::Matrix<double, kLimbAngles, kLimbAngles> hessian;
};

/// Throws nothing; finite for finite angles.
PosePrior pose_prior(Limb limb, const LimbAngles& angles, const PosePriorConfig& config);

} // namespace kinora::tracking
