#include "tracking/body/hand_contact.h"

namespace kinora::tracking {

std::size_t hand_part(Limb arm) { return chain_of(arm).parts.back(); }

PartPoint heel_point() { return {0, -Eigen::Vector3d::UnitY()}; }

Eigen::Vector3d heel_of_hand(const PosedBody& body, Limb arm) {
  const std::size_t part = hand_part(arm);
  return body.bones[body_parts()[part].bone] * position_of(body.parts[part], heel_point());
}

double contact_energy(const HandContact& contact, const PosedBody& body, const BodyEnergyConfig& config) {
  return config.contact_weight *
         robust_cost(config).cost((heel_of_hand(body, contact.arm) - contact.position).squaredNorm());
}

} // namespace kinora::tracking
