// Whether a frame is what its plugin's own description promises. Nobody can check that the pixels are there.
#pragma once

#include <string>

#include "kinora/plugin.h"

namespace kinora::host {

/// Why the frame cannot be used, as "gave no colour image of the camera's size …"; empty if it can. Rows may have gaps
/// between them, and may not overlap.
std::string fault_of(const KinoraFrame& frame, const KinoraCaptureInfo& info);

} // namespace kinora::host
