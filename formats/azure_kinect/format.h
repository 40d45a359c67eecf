// Azure Kinect's recordings as captures, for the table of built-in formats.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

extern const KinoraFormat kAzureKinectFormat; ///< azure-kinect

} // namespace kinora::formats
