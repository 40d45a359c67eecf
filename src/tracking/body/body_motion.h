// Where each bone of a person went, and which bone a point of the person goes with.
#pragma once

#include <optional>
#include <vector>

#include "tracking/body/body_model.h"
#include "tracking/body/limb_search.h"

namespace kinora::tracking {

/// One frame's body in the world.
struct BodyFrame {
  BodyPose pose;
  std::array<LimbHealth, kLimbs> limbs{};
};

/// A point's bones: `bone` holds it by `weight`, `second` (its parent or child) by the rest.
struct BoneHold {
  Joint bone, second;
  double weight; ///< in [0.5, 1]
};

/// The bones of a point beside the body; nothing if it is farther than `reach` metres from the body's surface.
std::optional<BoneHold> hold_of(const PosedBody& body, const Eigen::Vector3d& point, double reach = 0.08);

/// Plain data; thread-safe to read. Canonical space = world at the first frame that the person was seen in.
class BodyMotion {
public:
  /// One frame of the clip each, in order; nothing before the person was first seen.
  BodyMotion(const Shape& shape, std::vector<std::optional<BodyFrame>> frames);

  const std::vector<std::optional<BodyFrame>>& frames() const { return frames_; }
  /// Places of all joints in the world; nothing before the first.
  std::optional<Bones> bones(std::size_t frame) const;
  /// Carries a canonical point of the bone to where it is in the frame (world); before the first frame, as in that.
  SE3 canonical_to_world(std::size_t frame, Joint bone) const;

private:
  Shape shape_;
  std::vector<std::optional<BodyFrame>> frames_;
  PosedBody canonical_;
};

} // namespace kinora::tracking
