// The presets of the encoder: how much work each may cost.
#pragma once

#include <string>

#include "encode/settings.h"

namespace kinora::encode {

enum class Preset { kFast, kBalanced };

/// "fast" or "balanced"; throws Error(kUsage) for anything else.
Preset parse_preset(const std::string& name);
std::string name_of(Preset preset);

/// The documented budget of a preset (docs/encoding.md).
TrainingBudget budget_of(Preset preset);

} // namespace kinora::encode
