// Pairs of videos as captures, for the table of built-in formats.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

extern const KinoraFormat kVideoPairFormat; ///< video-pair

} // namespace kinora::formats
