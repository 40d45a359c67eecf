// Frames of a person made of the model's own rounded cones, with known pose and measures.
#pragma once

#include <cstdint>
#include <optional>

#include "ingest/frame/frame.h"
#include "tracking/body/body_energy.h"
#include "tracking/view/layer_view.h"

namespace kinora::tracking::testing {

/// A rectangle of the picture (end excluded) that something of label 2 covers, one metre from the camera.
struct Cover {
  int u0, v0, u1, v1;
};

struct BodyScene {
  int width = 240;
  int height = 180;
  double focal = 200;
  double noise = 1; ///< in units of the sensor's σ(z)
  std::uint64_t seed = 1;
  std::optional<Cover> cover;
  std::optional<Cover> hole; ///< where no depth is measured
};

/// What a camera sees of the body (label 1) before a wall at 4 m (label 0). The state is in the camera.
ingest::Frame render_body(const BodyState& state, const BodyScene& scene = {});

/// Somebody who stands upright 2.3 m before the camera, turned by `degrees` from facing it, in rest_pose().
BodyState standing(double degrees, double height = 1.7);

/// Distance of a joint in two bodies, metres.
double joint_distance(const BodyState& a, const BodyState& b, Joint joint);
/// Over all joints.
double mean_joint_distance(const BodyState& a, const BodyState& b);

} // namespace kinora::tracking::testing
