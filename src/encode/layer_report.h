// What a layer was made of, as the encoder's report and the clip's metadata say it.
#pragma once

#include <nlohmann/json.hpp>

#include "encode/motion_refinement.h"
#include "encode/scene_tracker.h"
#include "fields/field.h"
#include "fields/geometry_trial.h"
#include "fields/trainer.h"

namespace kinora::encode {

/// To four places after the point.
double round4(double value);

nlohmann::json config_json(const fields::FieldConfig& config);
nlohmann::json geometry_json(const fields::GeometryTrial& trial);
nlohmann::json motion_json(const TrackedLabel& label, const tracking::Motion& motion);
nlohmann::json refinement_json(const MotionRefinement& refinement, std::size_t draft_rays);

} // namespace kinora::encode
