// Record3D's recordings as captures, for the table of built-in formats.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

extern const KinoraFormat kRecord3dFormat; ///< record3d

} // namespace kinora::formats
