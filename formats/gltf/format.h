// glTF binary files, for the table of built-in formats.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

extern const KinoraFormat kGltfFormat; ///< glb

} // namespace kinora::formats
