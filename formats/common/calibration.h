// intrinsics.json, intrinsics.txt and camera-intrinsics.txt.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "kinora/plugin.h"

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

/// Whether a lens has no distortion.
bool is_lens_straight(const KinoraCamera& camera);

/// intrinsics.json of the folder, as read_calibration reads it back to the bit. Throws Error(kUnwritableOutput).
void write_calibration(const std::filesystem::path& folder, const KinoraCamera& camera, double frames_per_second,
                       double depth_unit);

} // namespace kinora::formats
