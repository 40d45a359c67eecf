// Whether depth was read in the unit that it was written in.
#pragma once

#include <string>

#include "core/image.h"

namespace kinora::ingest {

/// What speaks against a frame's unit of depth, as a sentence for people; empty if nothing does. Depth cameras see
/// rooms: half of what they measure lies neither within 0.25 m nor beyond 15 m. `depth`: metres; 0 is not measured.
std::string depth_unit_warning(const DepthImage& depth);

} // namespace kinora::ingest
