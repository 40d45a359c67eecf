// A video file that libavformat takes apart.
#pragma once

#include "libav/libav.h"

namespace kinora::formats {

/// Throws Error(kCorruptInput), naming the path.
libav::Input open_input(const std::filesystem::path& path);

/// When a packet's picture is shown, in seconds.
double time_of(std::int64_t timestamp, const AVStream& stream);

} // namespace kinora::formats
