// How a clip remembers the two cameras of its capture, so that the capture can be read the same way again.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "ingest/depth/registration.h"

namespace kinora::ingest {

/// {"depth", "color": {"width", "height", "fx", "fy", "cx", "cy"}, "depth_to_color": 4×4, row by row}
nlohmann::json to_json(const RegistrationGeometry& geometry);
/// Throws Error(kCorruptInput), naming `source`, if it is not what to_json makes or cannot be two cameras.
RegistrationGeometry registration_from_json(const nlohmann::json& json, const std::string& source);

} // namespace kinora::ingest
