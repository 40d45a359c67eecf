// A field that shows by its colour how it is turned.
#pragma once

#include "core/camera.h"
#include "painted_field.h"

namespace kinora::fields::testing {

/// A ball whose vectors all point along x, before a camera at the origin.
struct ArrowBall {
  PaintedBall ball{{0, 0, 2}, 0.3};
  double arrow = 0.4;

  Field field() const {
    const auto shape = [this](const Eigen::Vector3d& p) { return Paint{ball(p).distance, {arrow, 0, 0}}; };
    return painted_field({{-0.5, -0.5, 1.5}, 1}, shape, 8, true);
  }
  Camera camera() const { return {{64, 64, 100, 100, 31.5, 31.5}, SE3::Identity()}; }
  /// Turned about its middle.
  SE3 pose(const Eigen::Matrix3d& rotation) const {
    SE3 pose = SE3::Identity();
    pose.linear() = rotation;
    pose.translation() = ball.centre - rotation * ball.centre;
    return pose;
  }
  /// The colour of a ball that is turned so, sRGB in [0, 1].
  Eigen::Array3d expected(const Eigen::Matrix3d& rotation) const {
    const Eigen::Array3d rotated = 0.5 + arrow * rotation.col(0).array();
    return 1 / (1 + (4 - 8 * rotated).exp());
  }
};

} // namespace kinora::fields::testing
