// OpenVDB volumes, for the table of built-in formats.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

/// openvdb. Where the library was not there when Kinora was built, everything that it is asked for fails with
/// KINORA_MISSING (unavailable.cpp).
extern const KinoraFormat kOpenVdbFormat;

} // namespace kinora::formats
