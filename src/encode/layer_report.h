// What a layer was made of, as the encoder's report and the clip's metadata say it.
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "encode/layer_training.h"

namespace kinora::encode {

/// For the report: what was modelled and why, size, tracking health, geometry and training.
nlohmann::json layer_json(const TrackedLabel& tracked, const LayerOutcome& outcome);
/// For the clip: why the layer moves as it does, and the configuration of its field and of its training.
nlohmann::json layer_metadata(const LayerOutcome& outcome);
/// For both.
nlohmann::json not_modelled_json(const std::vector<NotModelled>& labels);

} // namespace kinora::encode
