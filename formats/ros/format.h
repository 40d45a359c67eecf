// ROS logs as captures, for the table of built-in formats.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

extern const KinoraFormat kRosBagFormat; ///< ros-bag
extern const KinoraFormat kMcapFormat;   ///< mcap

} // namespace kinora::formats
