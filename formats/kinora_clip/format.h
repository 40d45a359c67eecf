// Clips as captures, for the table of built-in formats.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

extern const KinoraFormat kClipFormat; ///< kinora-clip

} // namespace kinora::formats
