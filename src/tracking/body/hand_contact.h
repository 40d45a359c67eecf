// A hand that holds something is where that is, though the camera may not see it.
// Source: Jiang et al., "Instant-NVR", CVPR 2023, eq. 2 (interaction).
#pragma once

#include "tracking/body/body_evidence.h"
#include "tracking/body/limbs.h"

namespace kinora::tracking {

/// An arm's hand, and where what it holds would have its heel.
struct HandContact {
  Limb arm;
  Eigen::Vector3d position; ///< in the space around the body, metres
};

/// The part of the body that is the arm's hand, and its heel: the point of its surface below the wrist.
std::size_t hand_part(Limb arm);
PartPoint heel_point();
Eigen::Vector3d heel_of_hand(const PosedBody& body, Limb arm);

/// What it costs that the hand is elsewhere: as much as for a few patches of measured surface, so that more of them
/// draw it away (BodyEnergyConfig::contact_weight).
double contact_energy(const HandContact& contact, const PosedBody& body, const BodyEnergyConfig& config);

} // namespace kinora::tracking
