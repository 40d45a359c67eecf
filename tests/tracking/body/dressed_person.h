// A person in clothes as an analytic surface, with colours and points that stick to it. Not what the tracker's body
// model looks like: other measures, folded cloth on trunk and limbs, and a skirt if wanted.
#pragma once

#include <optional>

#include "tracking/body/body_evidence.h"

namespace kinora::tracking::testing {

/// A cone that hangs from the waist. What it does at its hem, in the pelvis' axes; above it does less.
struct Skirt {
  Eigen::Vector2d swing = Eigen::Vector2d::Zero(); ///< metres to the left and forward
  double twist = 0;                                ///< radians about the axis upwards
};

/// A point of the person's surface.
struct CoatPoint {
  std::size_t part;  ///< of the body; kBodyParts: of the skirt
  PartPoint of_part; ///< of the skirt: `along` is the share of its length, `direction.x()` the angle about it
};

/// One instant. The state is in the camera. Thread-safe to read.
class DressedPerson {
public:
  explicit DressedPerson(const BodyState& state, const std::optional<Skirt>& skirt = {});

  struct Hit {
    double z = 0; ///< along the optical axis
    CoatPoint point;
    Eigen::Vector3d normal;
  };
  /// Where a ray (of unit z, from the camera) meets the person first.
  std::optional<Hit> trace(const Eigen::Vector3d& ray) const;
  /// Where a material point is.
  Eigen::Vector3d coat_position(const CoatPoint& point) const;
  const BodyInCamera& body() const { return body_; }

  /// Reflectance of red, green and blue at a material point; the skin of head and hands has little texture.
  static Eigen::Vector3d colour_of(const CoatPoint& point);

private:
  struct Sample {
    double distance; ///< to first order
    CoatPoint point;
    Eigen::Vector3d normal;
  };
  Sample sample(std::size_t part, const Eigen::Vector3d& position) const;
  Sample sample_skirt(const Eigen::Vector3d& position) const;

  BodyInCamera body_;
  std::optional<Skirt> skirt_;
  SE3 waist_; ///< of the skirt: axes of the pelvis, upright
};

/// Somebody tall and stout with long arms (or short and slight), who stands 2.4 m before the camera and faces it.
BodyState tall_person();
BodyState short_person();

} // namespace kinora::tracking::testing
