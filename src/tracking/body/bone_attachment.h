// Which bone a point of a person goes with.
#pragma once

#include <optional>

#include "tracking/body/body_model.h"

namespace kinora::tracking {

/// A point's bones: `bone` holds it by `weight`, `second` (its parent or child) by the rest.
struct BoneAttachment {
  Joint bone, second;
  double weight; ///< in [0.5, 1]
};

/// Metres from a point to the surface about a bone, negative within it; a large number if no surface is about it.
double distance_to_bone(const PosedBody& body, Joint bone, const Eigen::Vector3d& point);

/// The bones of a point beside the body; nothing if it is farther than `reach` metres from the body's surface.
std::optional<BoneAttachment> attach_to_bones(const PosedBody& body, const Eigen::Vector3d& point, double reach = 0.08);

} // namespace kinora::tracking
