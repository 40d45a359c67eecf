// How long the capture's camera took to read the rows of a picture (rolling_shutter.h); what a clip shows is of one
// moment.
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "clip/clip.h"
#include "core/se3.h"

namespace kinora::clip {

/// Into a clip's metadata, as "rolling_shutter"; nothing for a camera that reads all rows at once (0).
void store_readout(double seconds, nlohmann::json& metadata);

/// Seconds; negative: the last row first. 0 if a clip's metadata tell nothing, or nothing that can be understood.
double stored_readout(const nlohmann::json& metadata);

/// How the camera moved meanwhile in each frame of the clip; empty if it did not, or read all rows at once.
std::vector<Twist> readout_of_frames(const Clip& clip);

} // namespace kinora::clip
