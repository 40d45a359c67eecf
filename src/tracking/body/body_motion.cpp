#include "tracking/body/body_motion.h"

#include <algorithm>

#include "core/error.h"

namespace kinora::tracking {
namespace {

const BodyFrame& first_of(const std::vector<std::optional<BodyFrame>>& frames) {
  const auto first = std::find_if(frames.begin(), frames.end(), [](const auto& frame) { return frame.has_value(); });
  if (first == frames.end()) throw Error(ErrorCode::kFailure, "the person was seen in no frame");
  return **first;
}

bool are_neighbours(Joint a, Joint b) { return joints()[a].parent == b || joints()[b].parent == a; }

} // namespace

BodyMotion::BodyMotion(const Shape& shape, std::vector<std::optional<BodyFrame>> frames)
    : shape_(shape), frames_(std::move(frames)), canonical_(pose_body(first_of(frames_).pose, shape_)) {}

std::optional<Bones> BodyMotion::bones(std::size_t frame) const {
  if (!frames_.at(frame)) return std::nullopt;
  return place_bones(frames_[frame]->pose, shape_);
}

SE3 BodyMotion::canonical_to_world(std::size_t frame, Joint bone) const {
  const std::optional<Bones> now = bones(frame);
  return now ? (*now)[bone] * canonical_.bones[bone].inverse() : SE3::Identity();
}

std::optional<BoneHold> hold_of(const PosedBody& body, const Eigen::Vector3d& point, double reach) {
  constexpr double kBlend = 0.05; // metres that one bone is nearer than the other where it begins to hold alone
  std::array<double, kJoints> distances;
  distances.fill(1e9);
  for (std::size_t i = 0; i < kBodyParts; ++i) {
    const Joint bone = body_parts()[i].bone;
    const Eigen::Vector3d local = body.bones[bone].inverse() * point;
    distances[bone] = std::min(distances[bone], closest_surface(body.parts[i], local).distance);
  }
  const auto nearest = std::min_element(distances.begin(), distances.end());
  if (*nearest > reach) return std::nullopt;
  const auto bone = static_cast<Joint>(nearest - distances.begin());
  BoneHold hold{bone, bone, 1};
  double gap = kBlend;
  for (int j = 0; j < kJoints; ++j) {
    const auto other = static_cast<Joint>(j);
    if (!are_neighbours(bone, other) || distances[other] - *nearest >= gap) continue;
    gap = distances[other] - *nearest;
    hold = {bone, other, 0.5 + 0.5 * gap / kBlend};
  }
  return hold;
}

} // namespace kinora::tracking
