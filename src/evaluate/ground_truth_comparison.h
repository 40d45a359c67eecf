// A clip against the truth that a synthetic capture knows: the object's pose, and cameras that the capture did not
// have.
#pragma once

#include <nlohmann/json.hpp>

#include "core/progress.h"
#include "evaluate/ground_truth.h"
#include "player/player.h"

namespace kinora::evaluate {

/// `object_pose` (if poses are known and label 2 is a layer): `error_m_mean`, `error_m_max` at the mesh's centroid and
/// `error_degrees_mean`, `error_degrees_max`, of the motion since the layer's first frame, over all later frames of the
/// clip; `novel_cameras`: per camera and layer the measures of evaluate.h over all its frames that the clip has.
nlohmann::json compare_with_ground_truth(const player::Player& player, const GroundTruth& truth, Progress& progress);

} // namespace kinora::evaluate
