#include "tracking/body/bone_attachment.h"

#include <algorithm>

namespace kinora::tracking {
namespace {

constexpr double kFarAway = 1e9; // metres

bool are_neighbours(Joint a, Joint b) { return joints()[a].parent == b || joints()[b].parent == a; }

} // namespace

double distance_to_bone(const PosedBody& body, Joint bone, const Eigen::Vector3d& point) {
  const Eigen::Vector3d local = body.bones[bone].inverse() * point;
  double nearest = kFarAway;
  for (std::size_t i = 0; i < kBodyParts; ++i) {
    if (body_parts()[i].bone == bone) nearest = std::min(nearest, closest_surface(body.parts[i], local).distance);
  }
  return nearest;
}

std::optional<BoneAttachment> attach_to_bones(const PosedBody& body, const Eigen::Vector3d& point, double reach) {
  constexpr double kBlend = 0.05; // metres that one bone is nearer than the other where it begins to hold alone
  std::array<double, kJoints> distances;
  for (int j = 0; j < kJoints; ++j) {
    distances[static_cast<std::size_t>(j)] = distance_to_bone(body, static_cast<Joint>(j), point);
  }
  const auto nearest = std::min_element(distances.begin(), distances.end());
  if (*nearest > reach) return std::nullopt;
  const auto bone = static_cast<Joint>(nearest - distances.begin());
  BoneAttachment attachment{bone, bone, 1};
  double gap = kBlend;
  for (int j = 0; j < kJoints; ++j) {
    const auto other = static_cast<Joint>(j);
    if (!are_neighbours(bone, other) || distances[other] - *nearest >= gap) continue;
    gap = distances[other] - *nearest;
    attachment = {bone, other, 0.5 + 0.5 * gap / kBlend};
  }
  return attachment;
}

} // namespace kinora::tracking
