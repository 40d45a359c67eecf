// Motions of nodes that tests of blending share.
#pragma once

#include <cmath>
#include <numbers>

#include "core/random.h"
#include "motion/skinning/blended_motion.h"

namespace kinora::motion::testing {

inline Eigen::Vector3d random_vector(Random& random, double size) {
  return size * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
}

/// The same transform.
inline DualQuaternion negated(DualQuaternion transform) {
  transform.real.coeffs() *= -1;
  transform.dual.coeffs() *= -1;
  return transform;
}

/// Four half turns about axes at right angles, whose sum vanishes without care for their hemispheres.
struct CancellingRotations {
  NodeStates states;
  Influence influence;

  CancellingRotations() {
    influence.count = 4;
    influence.weights = {0.25, 0.25, 0.25, 0.25};
    for (int i = 0; i < 4; ++i) {
      influence.nodes[static_cast<std::size_t>(i)] = i;
      const double angle = 0.5 * std::numbers::pi * i;
      const Eigen::Vector3d axis(std::cos(angle), std::sin(angle), 0);
      states.push_back(DualQuaternion::from(SE3(Eigen::AngleAxisd(std::numbers::pi, axis))), Eigen::Vector3d::Zero());
    }
  }
};

} // namespace kinora::motion::testing
