// How bright each frame of the capture was recorded, beside what the clip shows.
#pragma once

#include <map>

#include <nlohmann/json.hpp>

#include "core/color_gain.h"

namespace kinora::clip {

/// By number of the capture's frame: recorded light = gain · light of the clip. Frames of even exposure need none.
using Exposure = std::map<int, ColorGain>;

/// Into a clip's metadata, as "exposure"; nothing if it is empty.
void store_exposure(const Exposure& exposure, nlohmann::json& metadata);

/// What a clip's metadata tell. Empty if they tell nothing, or nothing that can be understood.
Exposure stored_exposure(const nlohmann::json& metadata);

/// Of any frame of the capture: between two that are known by how far it is from each, beyond them the nearest one's.
ColorGain gain_at(const Exposure& exposure, int capture_frame);

} // namespace kinora::clip
