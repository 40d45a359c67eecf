// Pinhole cameras. Axes: x right, y down, z forward (OpenCV). Pixel centres lie at integer coordinates.
#pragma once

#include <string>

#include <Eigen/Core>

#include "core/se3.h"

namespace kinora {

/// Pinhole intrinsics of an undistorted image, in pixels: u = fx·X/Z + cx, v = fy·Y/Z + cy.
struct Intrinsics {
  int width = 0;
  int height = 0;
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;

  /// Camera-frame point (metres, z > 0) to pixel coordinates.
  Eigen::Vector2d project(const Eigen::Vector3d& point) const {
    return {fx * point.x() / point.z() + cx, fy * point.y() / point.z() + cy};
  }
  /// The camera-frame point on the plane z = depth that is seen at pixel (u, v).
  Eigen::Vector3d unproject(double u, double v, double depth) const {
    return {(u - cx) / fx * depth, (v - cy) / fy * depth, depth};
  }
  /// The same view in an image of another size (pixel centres stay at integers).
  Intrinsics resized(int new_width, int new_height) const;

  /// Throws Error(kCorruptInput), naming `source`, if the numbers cannot belong to a camera.
  void validate(const std::string& source) const;

  bool operator==(const Intrinsics&) const = default;
};

/// Brown–Conrady lens distortion (OpenCV's k1 k2 p1 p2 k3); all zero for a rectified image.
struct Distortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;
  bool is_zero() const { return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0 && k3 == 0; }
};

/// A camera in the world.
struct Camera {
  Intrinsics intrinsics;
  SE3 camera_to_world = SE3::Identity();
};

} // namespace kinora
