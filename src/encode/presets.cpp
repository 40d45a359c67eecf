#include "encode/presets.h"

#include <array>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::encode {
namespace {

struct NamedPreset {
  Preset preset;
  const char* name;
  double rays_per_pixel;
  std::size_t min_rays;
  std::size_t max_rays;
  bool try_geometries;
};

constexpr std::array<NamedPreset, 3> kPresets{{
    {Preset::kFast, "fast", 0.2, 500'000, 20'000'000, false},
    {Preset::kBalanced, "balanced", 1.2, 2'000'000, 80'000'000, false},
    {Preset::kBest, "best", 4.8, 8'000'000, 400'000'000, true},
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
  throw Error(ErrorCode::kUsage, fmt::format("there is no preset \"{}\"; use fast, balanced or best", name));
}

std::string name_of(Preset preset) { return entry_of(preset).name; }

TrainingBudget budget_of(Preset preset) {
  const NamedPreset& entry = entry_of(preset);
  TrainingBudget budget;
  budget.rays_per_pixel = entry.rays_per_pixel;
  budget.min_rays = entry.min_rays;
  budget.max_rays = entry.max_rays;
  budget.try_geometries = entry.try_geometries;
  return budget;
}

} // namespace kinora::encode
