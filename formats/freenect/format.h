// Live cameras of the first Kinect, for the table of built-in formats. libfreenect is in a module (module.cpp), which
// is left out where the library is not there when Kinora is built.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

const KinoraFormat& freenect_format();

} // namespace kinora::formats
