// Where a layer's canonical points are at every frame of a clip.
#pragma once

#include <string_view>
#include <vector>

#include "core/se3.h"

namespace kinora::tracking {

enum class MotionKind { kStill, kRigid };
enum class Health { kTracked, kHeld, kLost };

std::string_view name_of(MotionKind kind);
std::string_view name_of(Health health);

/// Canonical space of a layer = world space at the layer's first frame. Plain data; thread-safe to read.
class Motion {
public:
  /// One pose of a rigid layer.
  struct Pose {
    SE3 canonical_to_world = SE3::Identity();
    Health health = Health::kTracked;
  };

  static Motion still() { return Motion(MotionKind::kStill, {}); }
  /// One pose for each frame of the clip, in order. Throws Error(kFailure) if there is none.
  static Motion rigid(std::vector<Pose> poses);

  MotionKind kind() const { return kind_; }
  /// Empty for a still layer.
  const std::vector<Pose>& poses() const { return poses_; }

  /// At a whole or fractional frame; in between, along the screw from one pose to the next; clamped at both ends.
  SE3 canonical_to_world(double frame) const;
  /// A still layer is always tracked; beyond the last frame, that of the last.
  Health health(std::size_t frame) const;

private:
  Motion(MotionKind kind, std::vector<Pose> poses) : kind_(kind), poses_(std::move(poses)) {}

  MotionKind kind_;
  std::vector<Pose> poses_;
};

} // namespace kinora::tracking
