// Wavefront OBJ files, for the table of built-in formats.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

extern const KinoraFormat kObjFormat;

} // namespace kinora::formats
