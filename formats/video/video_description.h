// What a video file holds.
#pragma once

#include "common/video_file.h"

namespace kinora::formats {

/// As describe_video.
VideoDescription read_description(const std::filesystem::path& path);

} // namespace kinora::formats
