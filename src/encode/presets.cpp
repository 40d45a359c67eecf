#include "encode/presets.h"

#include <array>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::encode {
namespace {

struct NamedPreset {
  Preset preset;
  const char* name;
  double decibels_per_second;
};

constexpr std::array<NamedPreset, 2> kPresets{{
    {Preset::kFast, "fast", 10},
    {Preset::kBalanced, "balanced", 2},
}};

const NamedPreset& entry_of(Preset preset) {
  for (const NamedPreset& entry : kPresets) {
    if (entry.preset == preset) return entry;
  }
  throw Error(ErrorCode::kFailure, "a preset without a budget");
}

} // namespace

Preset parse_preset(const std::string& name) {
  for (const NamedPreset& entry : kPresets) {
    if (name == entry.name) return entry.preset;
  }
  throw Error(ErrorCode::kUsage, fmt::format("there is no preset \"{}\"; use fast or balanced", name));
}

std::string name_of(Preset preset) { return entry_of(preset).name; }

TrainingBudget budget_of(Preset preset) {
  const NamedPreset& entry = entry_of(preset);
  TrainingBudget budget;
  budget.decibels_per_second = entry.decibels_per_second;
  return budget;
}

} // namespace kinora::encode
