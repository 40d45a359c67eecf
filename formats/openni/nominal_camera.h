// The camera of a picture from how far OpenNI says that it sees.
#pragma once

#include <cmath>

#include "core/camera.h"

namespace kinora::formats {

/// Angles in radians, from border to border. `focal_length` in pixels decides if it is not 0; where the angles are 0
/// too, it is 525 of 640 pixels.
inline Intrinsics nominal_camera(int width, int height, double horizontal, double vertical, double focal_length) {
  constexpr double kUsualFocalLength = 525.0 / 640;
  const double given = focal_length > 0 ? focal_length : kUsualFocalLength * width;
  const bool told = focal_length == 0 && horizontal > 0 && horizontal < 3 && vertical > 0 && vertical < 3;
  const double fx = told ? width / (2 * std::tan(horizontal / 2)) : given;
  const double fy = told ? height / (2 * std::tan(vertical / 2)) : given;
  return {width, height, fx, fy, (width - 1) / 2.0, (height - 1) / 2.0};
}

/// Whether depth of this camera lies pixel by pixel over that one's colour.
inline bool is_same_camera(const Intrinsics& a, const Intrinsics& b) {
  constexpr double kTolerance = 0.01; // of the focal length
  return a.width == b.width && a.height == b.height && std::abs(a.fx - b.fx) < kTolerance * b.fx &&
         std::abs(a.cx - b.cx) < 1 && std::abs(a.cy - b.cy) < 1;
}

inline constexpr const char* kUnknownView =
    "how far the camera sees is not known; its focal length is taken as 525 of 640 pixels (-O focal=PIXELS)";

} // namespace kinora::formats
