// MP4 films, for the table of built-in formats. FFmpeg's libraries are in a module (module.cpp).
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

const KinoraFormat& mp4_format();

} // namespace kinora::formats
