// OpenEXR pictures and captures, for the table of built-in formats. The OpenEXR library is in a module (module.cpp),
// which is left out where the library is not there when Kinora is built.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

const KinoraFormat& exr_format();          ///< exr
const KinoraFormat& exr_sequence_format(); ///< exr-sequence

} // namespace kinora::formats
