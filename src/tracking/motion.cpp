#include "tracking/motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"

namespace kinora::tracking {

std::string_view name_of(MotionKind kind) { return kind == MotionKind::kStill ? "still" : "rigid"; }

std::string_view name_of(Health health) {
  switch (health) {
  case Health::kTracked:
    return "tracked";
  case Health::kHeld:
    return "held";
  case Health::kLost:
    return "lost";
  }
  throw Error(ErrorCode::kFailure, "a pose has a health that is none of tracked, held and lost; the clip is damaged");
}

Motion Motion::rigid(std::vector<Pose> poses) {
  if (poses.empty()) throw Error(ErrorCode::kFailure, "a rigid motion needs a pose for at least one frame");
  return {MotionKind::kRigid, std::move(poses)};
}

SE3 Motion::canonical_to_world(double frame) const {
  if (kind_ == MotionKind::kStill) return SE3::Identity();
  const double last = static_cast<double>(poses_.size() - 1);
  const double clamped = frame > 0 ? std::min(frame, last) : 0; // NaN goes to the first frame
  const double whole = std::floor(clamped);
  const std::size_t i = static_cast<std::size_t>(whole);
  if (clamped == whole) return poses_[i].canonical_to_world;
  return interpolate(poses_[i].canonical_to_world, poses_[i + 1].canonical_to_world, clamped - whole);
}

Health Motion::health(std::size_t frame) const {
  if (kind_ == MotionKind::kStill) return Health::kTracked;
  return poses_[std::min(frame, poses_.size() - 1)].health;
}

} // namespace kinora::tracking
