// intrinsics.json, intrinsics.txt and camera-intrinsics.txt.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/camera.h"

namespace kinora::formats {

struct Calibration {
  Intrinsics intrinsics; ///< width and height are 0 where the file does not say (text files never do)
  Distortion distortion;
  std::optional<double> depth_unit;        ///< metres per unit of the depth images
  std::optional<double> frames_per_second; ///< nominal
  std::filesystem::path source;            ///< the file it comes from
};

/// Reads the first of intrinsics.json, intrinsics.txt, camera-intrinsics.txt in the first of `folders` that has one.
/// JSON: fx fy cx cy, and optionally width height depth_factor (units per metre) | depth_scale_m (metres per unit),
/// distortion [k1 k2 p1 p2 k3], fps, depth_registered_to_color. Text: a 3×3 or 4×4 matrix with K at its upper left.
/// Throws Error(kCorruptInput) if there is none or its numbers cannot belong to a camera.
Calibration read_calibration(const std::vector<std::filesystem::path>& folders);

} // namespace kinora::formats
