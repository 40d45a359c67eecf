// How far the clip's motion carries material points from where they truly are.
#pragma once

#include <nlohmann/json.hpp>

#include "clip/clip.h"
#include "evaluate/ground_truth_tracks.h"

namespace kinora::evaluate {

/// Each point is given to the layer with label 1 (the person, on whom the points lie) at the first frame of the clip
/// that shows it, and followed through all frames. For the places that the capture camera sees (`visible`, without the
/// given one) and for the others (`hidden`): `places`, `error_m_mean`, `error_m_p95`, and `missing`: those at frames
/// where the layer is lost, which count in the other numbers too. Null without such a layer or without points.
nlohmann::json track_error(const clip::Clip& clip, const GroundTruthTracks& tracks);

} // namespace kinora::evaluate
