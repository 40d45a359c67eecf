// What a folder of RGB-D images holds, whatever its layout: the formats differ only in how they make this list.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/calibration.h"
#include "common/captures.h"
#include "core/se3.h"
#include "kinora/plugin.h"

namespace kinora::formats {

/// The files of one frame. Nothing has been opened yet.
struct FrameFiles {
  double time = 0; ///< seconds
  std::filesystem::path color;
  std::filesystem::path depth;
  std::vector<std::filesystem::path> masks; ///< one, or one per object; empty: the frame has no mask
  std::filesystem::path pose_file;          ///< a 4×4 camera-to-world matrix; empty if there is none
  std::optional<SE3> camera_to_world;       ///< when the pose comes from a list for all frames
  std::string problem;                      ///< why the frame cannot be used; empty if it can
};

/// A depth camera of its own, whose images are not registered to colour.
struct DepthCamera {
  Intrinsics intrinsics; ///< with width and height
  Distortion distortion;
  SE3 depth_to_color = SE3::Identity();
};

struct Listing {
  std::vector<FrameFiles> frames; ///< in order of time
  Calibration calibration;
  std::optional<DepthCamera> depth_camera; ///< nothing: depth is registered to colour, pixel by pixel
  double frames_per_second = 30;
  bool has_poses = false;
  std::vector<std::string> warnings;
};

/// Makes the list. Throws Error(kCorruptInput) if the folder is of the layout but cannot be used as a whole.
Listing list_tum(const std::filesystem::path& folder);
Listing list_numbered(const std::filesystem::path& folder);
Listing list_3dmatch(const std::filesystem::path& folder);
Listing list_m3t(const std::filesystem::path& folder);
Listing list_transforms(const std::filesystem::path& folder);

/// The plugin interface's `probe` for each layout.
void probe_tum(const char* path, KinoraProbe* answer);
void probe_numbered(const char* path, KinoraProbe* answer);
void probe_3dmatch(const char* path, KinoraProbe* answer);
void probe_m3t(const char* path, KinoraProbe* answer);
void probe_transforms(const char* path, KinoraProbe* answer);

} // namespace kinora::formats
