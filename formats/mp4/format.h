// MP4 films, for the table of built-in formats.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

extern const KinoraFormat kMp4Format; ///< mp4

} // namespace kinora::formats
