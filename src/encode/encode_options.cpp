#include "encode/encode_options.h"

#include <array>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::encode {
namespace {

struct PresetBudget {
  Preset preset;
  const char* name;
  double rays_per_pixel;
  std::size_t min_rays;
  std::size_t max_rays;
  bool try_geometries;
};

constexpr std::array<PresetBudget, 3> kPresets{{
    {Preset::kFast, "fast", 0.2, 500'000, 20'000'000, false},
    {Preset::kBalanced, "balanced", 1.2, 2'000'000, 80'000'000, false},
    {Preset::kBest, "best", 4.8, 8'000'000, 400'000'000, true},
}};

const PresetBudget& budget_of(Preset preset) {
  for (const PresetBudget& budget : kPresets) {
    if (budget.preset == preset) return budget;
  }
  throw Error(ErrorCode::kFailure, "a preset without a budget");
}

} // namespace

Preset parse_preset(const std::string& name) {
  for (const PresetBudget& budget : kPresets) {
    if (name == budget.name) return budget.preset;
  }
  throw Error(ErrorCode::kUsage, fmt::format("there is no preset \"{}\"; use fast, balanced or best", name));
}

std::string name_of(Preset preset) { return budget_of(preset).name; }

EncodeOptions EncodeOptions::of(Preset preset) {
  const PresetBudget& budget = budget_of(preset);
  EncodeOptions options;
  options.preset = preset;
  options.settings.budget.rays_per_pixel = budget.rays_per_pixel;
  options.settings.budget.min_rays = budget.min_rays;
  options.settings.budget.max_rays = budget.max_rays;
  options.settings.budget.try_geometries = budget.try_geometries;
  return options;
}

std::size_t EncodeOptions::expected_frames(int frame_count) const {
  return static_cast<std::size_t>(std::max(1, frames.count_of(frame_count)));
}

nlohmann::json EncodeOptions::json() const {
  return {{"preset", name_of(preset)},
          {"holdout", holdout},
          {"body_from", body_from},
          {"frames", {{"begin", frames.begin}, {"end", frames.end.value_or(-1)}, {"step", frames.step}}}};
}

} // namespace kinora::encode
