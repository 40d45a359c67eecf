// One OpenEXR file as a frame of a capture.
#pragma once

#include <filesystem>
#include <optional>

#include "core/camera.h"
#include "core/image.h"
#include "core/se3.h"

namespace kinora::formats {

/// What a file's header says.
struct ExrHead {
  int width = 0;
  int height = 0;
  std::optional<double> time; ///< seconds, where the file says it
  std::optional<double> frames_per_second;
  std::optional<SE3> camera_to_world;   ///< Kinora's axes
  std::optional<Intrinsics> intrinsics; ///< with width and height
  bool has_labels = false;
  std::optional<double> depth_unit; ///< metres, of a capture that was written as OpenEXR
};

/// Throws Error(kCorruptInput), naming the path, if it is no OpenEXR file or its size or pose is absurd.
ExrHead read_exr_head(const std::filesystem::path& path);

struct ExrFrame {
  ColorImage color;   ///< 3 channels, sRGB
  DepthImage16 depth; ///< units; 0 where Z is nothing that can be measured
  double depth_unit = 0;
  LabelImage labels;     ///< empty if there is none
  LabelImage confidence; ///< empty if there is none
  DepthImage16 infrared; ///< empty if there is none
};

/// Pixels outside of the data window are black and not measured. Throws Error(kCorruptInput), naming the path, if the
/// pixels cannot be read, or there is no colour (R G B) or no depth (Z).
ExrFrame read_exr_frame(const std::filesystem::path& path, const ExrHead& head);

} // namespace kinora::formats
