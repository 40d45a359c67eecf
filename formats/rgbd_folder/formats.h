// The formats of this folder, for the table of built-in formats.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

extern const KinoraFormat kTumFormat;         ///< tum-rgbd
extern const KinoraFormat kNumberedFormat;    ///< numbered-folder
extern const KinoraFormat kThreeDMatchFormat; ///< 3dmatch
extern const KinoraFormat kM3tFormat;         ///< m3t
extern const KinoraFormat kTransformsFormat;  ///< transforms

} // namespace kinora::formats
