// OpenNI's recordings and live cameras, for the table of built-in formats. Its library is in a module (module.cpp),
// which is left out where it is not there when Kinora is built; recordings are read without it.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

extern const KinoraFormat kOniFormat; ///< oni
const KinoraFormat& openni_format();

} // namespace kinora::formats
