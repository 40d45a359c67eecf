// Frames of a textured plate that bends, stretches and moves, with the true place of each of its points.
#pragma once

#include "synthetic_scene.h"

namespace kinora::tracking::testing {

/// A plate in its own x–y plane, facing −z, rolled about its y axis.
struct Plate {
  double half_width = 0.25; ///< metres, unstretched
  double half_height = 0.2;
  double curvature = 0; ///< 1/metres; positive: the sides go away from the camera
  double stretch = 0;   ///< of the width
  SE3 to_world = SE3::Identity();

  /// The place of a material point, x and y in metres of the flat, unstretched plate.
  Eigen::Vector3d position(double x, double y) const;
};

/// The frame that a camera at `camera_to_world` sees of the plate (label 2) before a wall at 4 m.
ingest::Frame render_plate(const Plate& plate, const SE3& camera_to_world, int index, const SceneOptions& options = {});

} // namespace kinora::tracking::testing
