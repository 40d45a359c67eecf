// What a layer's field was made how large for, and at what price: a part of the encoder's report.
#pragma once

#include <nlohmann/json.hpp>

#include "fields/training/trainer.h"

namespace kinora::encode {

/// `chosen` is what training began with, `field` what it ended with.
nlohmann::json size_json(const fields::FieldRequirements& requirements, const fields::FieldConfig& chosen,
                         const fields::Field& field, const fields::TrainingReport& training);

} // namespace kinora::encode
