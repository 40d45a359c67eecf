// How long the capture's camera took to read the rows of a picture (rolling_shutter.h); what a clip shows is of one
// moment.
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "clip/clip.h"
#include "core/se3.h"

namespace kinora::clip {

/// Seconds from the first row to the last; negative: the last row is first. 0: all rows are read at once.
struct Readout {
  double color = 0;
  double depth = 0;
};

/// Into a clip's metadata, as "rolling_shutter"; nothing for a camera that reads all rows of colour at once.
void store_readout(const Readout& readout, nlohmann::json& metadata);

/// All 0 if a clip's metadata tell nothing, or nothing that can be understood.
Readout stored_readout(const nlohmann::json& metadata);

/// How the camera moved meanwhile in one frame of the clip.
struct ReadoutMotion {
  Twist color = Twist::Zero();
  Twist depth = Twist::Zero();
};

/// In each frame; empty if the camera did not move, or read all rows at once.
std::vector<ReadoutMotion> readout_of_frames(const Clip& clip);

} // namespace kinora::clip
