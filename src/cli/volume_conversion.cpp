#include <optional>
#include <system_error>

#include <fmt/format.h>

#include "cli/clip_input.h"
#include "cli/conversion.h"
#include "cli/export_facts.h"
#include "cli/output_file.h"
#include "core/error.h"

namespace kinora::cli {
namespace fs = std::filesystem;
using Json = nlohmann::json;
namespace {

/// Volumes one after another, and the file that shows them in turn.
class VolumeIndex {
public:
  /// Nothing if none is asked for. Throws Error(kUnwritableOutput).
  VolumeIndex(const Conversion& conversion, bool overwrite) : conversion_(conversion) {
    if (!conversion.index) return;
    fs::path path = conversion.output;
    path.replace_extension(conversion.format->index_extension);
    out_.emplace(std::move(path), overwrite || conversion.resume, std::vector{conversion.input});
  }

  void add(std::size_t i, const fs::path& path, const Eigen::AlignedBox3d& box) {
    const auto time_of = [&](std::size_t n) {
      return conversion_.clip->times[static_cast<std::size_t>(conversion_.frames[n])];
    };
    const double time = conversion_.fps > 0 ? static_cast<double>(i) / conversion_.fps : time_of(i) - time_of(0);
    files_.push_back({path.filename().string(), time, box});
  }

  void write() {
    if (!out_) return;
    const double rate = conversion_.fps > 0 ? conversion_.fps : frames_per_second(*conversion_.clip);
    host::write_volume_index(*conversion_.format, out_->writing_path(), conversion_.format_options, files_, rate,
                             facts_of(conversion_));
    out_->commit();
  }

private:
  const Conversion& conversion_;
  std::optional<OutputFile> out_;
  std::vector<host::VolumeFile> files_;
};

} // namespace

Json convert_to_volumes(const Conversion& conversion, Context& context) {
  check_numbered_outputs(conversion, context.shared.overwrite);
  VolumeIndex index(conversion, context.shared.overwrite);
  bake::VolumeBaker baker(*conversion.clip, conversion.layers, conversion.volume);
  for (const std::size_t i : conversion.layers) report_lost_frames(conversion, conversion.clip->layers[i], context);
  const double start = conversion.clip->times[static_cast<std::size_t>(conversion.frames.front())];
  Json voxels = Json::array();
  std::uintmax_t bytes = 0;
  context.progress.stage("volumes", conversion.frames.size());
  for (std::size_t i = 0; i < conversion.frames.size(); ++i) {
    context.progress.check();
    const fs::path path = numbered_path(conversion.output, i);
    if (is_done(conversion, path)) {
      index.add(i, path, {});
      continue;
    }
    OutputFile out(path, context.shared.overwrite, {conversion.input});
    host::Volume volume = baker.at(conversion.frames[i], context.progress);
    volume.time -= start;
    volume.voxel_to_world.topRightCorner<3, 1>() -= conversion.origin;
    host::write_volume(*conversion.format, out.writing_path(), conversion.format_options, volume, facts_of(conversion));
    std::error_code ignored;
    if (out.can_be_read_back()) bytes += fs::file_size(out.writing_path(), ignored);
    out.commit();
    index.add(i, path, host::box_of(volume));
    voxels.push_back(volume.voxels.size());
    context.progress.advance(i + 1, fmt::format("{} voxels", volume.voxels.size()));
  }
  index.write();
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
