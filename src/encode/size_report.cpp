#include "encode/size_report.h"

#include <cmath>

#include <fmt/format.h>

#include "clip/payloads/touched_entries.h"
#include "encode/rounding.h"

namespace kinora::encode {
namespace {

using Json = nlohmann::json;

Json levels_json(const fields::Field& field) {
  const auto touched = clip::touched_entries(field.config, field.occupancy);
  Json levels = Json::array();
  for (const fields::GridLevel& level : fields::grid_levels(field.config)) {
    levels.push_back({{"cells_per_side", level.resolution},
                      {"entries", level.size},
                      {"hashed", level.hashed},
                      {"entries_stored", touched[levels.size()].size()}});
  }
  return levels;
}

Json growth_json(const std::vector<fields::TableGrowthTrial>& trials) {
  Json table_growth = Json::array();
  for (const fields::TableGrowthTrial& trial : trials) {
    table_growth.push_back({{"after_rays", trial.begin},
                            {"price_rays", trial.discarded_rays},
                            {"table_fill", std::round(trial.table_fill * 100) / 100},
                            {"log2_table_size", {trial.log2_table_size, trial.log2_table_size + 1}},
                            {"bytes", {trial.bytes, trial.grown_bytes}},
                            {"psnr_held_apart", {psnr(trial.error), psnr(trial.grown_error)}},
                            {"kept", trial.kept}});
  }
  return table_growth;
}

std::string why(const fields::FieldRequirements& requirements, const fields::FieldConfig& config) {
  return fmt::format("{} measured points fill a box of {:.3f} m; a pixel is {:.2f} mm wide there, a cell of the finest "
                     "level {:.2f} mm; the surface passes through about {:.0f} such cells, of which {} entries per "
                     "level keep what training works on near to the processor",
                     requirements.points, config.box.side, 1000 * requirements.footprint, 1000 * config.cell_size(),
                     requirements.surface_cells, 1 << config.log2_table_size);
}

} // namespace

Json size_json(const fields::FieldRequirements& requirements, const fields::FieldConfig& chosen,
               const fields::Field& field, const fields::TrainingReport& training) {
  return {{"why", why(requirements, chosen)},
          {"pixel_footprint_m", requirements.footprint},
          {"surface_cells", std::round(requirements.surface_cells)},
          {"levels", levels_json(field)},
          {"training_bytes", training.bytes},
          {"growth", growth_json(training.table_growth)}};
}

} // namespace kinora::encode
