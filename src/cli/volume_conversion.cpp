#include <system_error>

#include <fmt/format.h>

#include "cli/conversion.h"
#include "cli/output_file.h"
#include "core/error.h"

namespace kinora::cli {
namespace fs = std::filesystem;
using Json = nlohmann::json;

Json convert_to_volumes(const Conversion& conversion, Context& context) {
  check_numbered_outputs(conversion, context.shared.overwrite);
  bake::VolumeBaker baker(*conversion.clip, conversion.layers, conversion.volume);
  const double start = conversion.clip->times[static_cast<std::size_t>(conversion.frames.front())];
  Json voxels = Json::array();
  std::uintmax_t bytes = 0;
  context.progress.stage("volumes", conversion.frames.size());
  for (std::size_t i = 0; i < conversion.frames.size(); ++i) {
    context.progress.check();
    const fs::path path = numbered_path(conversion.output, i);
    if (is_done(conversion, path)) continue;
    OutputFile out(path, context.shared.overwrite, {conversion.input});
    host::Volume volume = baker.at(conversion.frames[i], context.progress);
    volume.time -= start;
    volume.voxel_to_world.topRightCorner<3, 1>() -= conversion.origin;
    host::write_volume(*conversion.format, out.writing_path(), conversion.format_options, volume, facts_of(conversion));
    std::error_code ignored;
    if (out.can_be_read_back()) bytes += fs::file_size(out.writing_path(), ignored);
    out.commit();
    voxels.push_back(volume.voxels.size());
    context.progress.advance(i + 1, fmt::format("{} voxels", volume.voxels.size()));
  }
  Json layers = Json::array();
  for (const std::size_t i : conversion.layers) {
    const clip::Layer& layer = conversion.clip->layers[i];
    layers.push_back({{"name", layer.name}, {"motion", motion::name_of(layer.motion.kind())}});
  }
  return {{"layers", std::move(layers)},
          {"files", conversion.frames.size()},
          {"bytes", bytes},
          {"voxels", std::move(voxels)}};
}

} // namespace kinora::cli
