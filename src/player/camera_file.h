// Cameras from a transforms.json, as instant-ngp and nerfstudio write it.
#pragma once

#include <filesystem>

#include "core/progress.h"
#include "player/view_path.h"

namespace kinora::player {

/// Reads `w h fl_x fl_y cx cy` (top level, or per frame, which wins; without fl_x: camera_angle_x in radians) and per
/// frame `transform_matrix` (camera to world, metres; camera axes x right, y up, z back), `time` in seconds from the
/// clip's start or `frame`, a number of the clip (neither: frame 0), and `file_path`, the picture's name. There, pixel
/// (0, 0) has its centre at (0.5, 0.5); the returned cameras have it at (0, 0), as everywhere in Kinora.
/// Lens distortion is warned of and ignored. Throws Error(kUsage) if there is no such file,
/// Error(kCorruptInput) naming file, frame and key; names that lead out of the output folder or occur twice are
/// refused.
std::vector<View> read_camera_file(const std::filesystem::path& path, const clip::Clip& clip, Progress& progress);

} // namespace kinora::player
