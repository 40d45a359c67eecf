#include "encode/settings.h"

#include <algorithm>
#include <string_view>

#include "core/error.h"

namespace kinora::encode {
namespace {

// Ends of paths. Everything else may be zero: it is switched off then.
constexpr std::string_view kPositive[] = {"sigma",
                                          "cutoff",
                                          "energy.patch",
                                          "motion.root_translation",
                                          "_rotation",
                                          "growth.weight_radius",
                                          "growth.influence_radius",
                                          "growth.sample_spacing",
                                          "topology.near",
                                          "camera.references",
                                          "camera.max_points",
                                          "feature_size",
                                          "_tolerance",
                                          "rays_per_step",
                                          "quantisation.coarse_steps",
                                          "quantisation.fine_steps",
                                          "training.rays",
                                          "first_rays",
                                          "pixels_per_frame",
                                          "refinement.rigidity",
                                          "solver.rigidity",
                                          "in_view.passes",
                                          "first_nodes",
                                          "in_view.max_points",
                                          "rigid.max_points",
                                          "tracker.max_points",
                                          "cleaning.gradient_radius"};

} // namespace

SettingList list_settings(Settings& settings) { return SettingList(settings); }

nlohmann::json settings_json(Settings settings) { return list_settings(settings).json(); }

void check(Settings settings) {
  for (const Setting& setting : list_settings(settings).all()) {
    const bool must_be_positive = std::any_of(std::begin(kPositive), std::end(kPositive),
                                              [&](std::string_view end) { return setting.path.ends_with(end); });
    if (must_be_positive && setting.get() == 0) {
      throw Error(ErrorCode::kUsage, fmt::format("the setting {} must be above zero", setting.path));
    }
  }
}

} // namespace kinora::encode
