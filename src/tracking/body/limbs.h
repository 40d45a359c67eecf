// Arms and legs as chains of two bones.
// Source: the two-bone chain of any textbook of animation (law of cosines, and a swivel about the line to the target).
#pragma once

#include <optional>
#include <vector>

#include "tracking/body/body_model.h"

namespace kinora::tracking {

enum Limb { kLeftArm, kRightArm, kLeftLeg, kRightLeg, kLimbs };
constexpr std::array<Limb, kLimbs> kEveryLimb = {kLeftArm, kRightArm, kLeftLeg, kRightLeg};

/// A ball joint, a hinge and what hangs from it.
struct LimbChain {
  Joint ball, hinge, end;
  Eigen::Vector3d axis;           ///< of the upper bone, in its own space
  std::vector<std::size_t> parts; ///< of the body, downwards
};
const LimbChain& chain_of(Limb limb);

/// Metres of a limb's two bones, and from its end joint to the end of its last part.
struct LimbLengths {
  double upper, lower, last;
};
LimbLengths lengths_of(const LimbChain& chain, const PosedBody& body);

/// Limbs that a bone belongs to; nothing for trunk and head.
std::optional<Limb> limb_of(Joint bone);

/// Angles of the limb that put its end joint (hand or foot stretched: a point `beyond` the end joint, metres) at
/// `target`, or as near as it gets, with the hinge turned by `swivel` about the line from the ball joint to the target.
/// All other angles stay; the end joint's are zero.
Angles inverse_kinematics(Limb limb, const Angles& angles, const PosedBody& body, const Eigen::Vector3d& target,
                          double swivel, double beyond);

} // namespace kinora::tracking
