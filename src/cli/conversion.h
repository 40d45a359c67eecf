// A clip turned into what a format plugin writes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bake/mesh_extraction.h"
#include "bake/volume.h"
#include "cli/context.h"
#include "clip/layer_choice.h"
#include "host/open_writer.h"
#include "host/plugin_table.h"

namespace kinora::cli {

/// What to convert, and into what.
struct Conversion {
  const clip::Clip* clip = nullptr;
  const KinoraFormat* format = nullptr;
  std::filesystem::path input;
  std::filesystem::path output;
  std::vector<int> frames; ///< of the clip, not decreasing
  clip::LayerChoice layers;
  bake::MeshExtractionOptions surface;
  bake::VolumeOptions volume;
  host::Options format_options;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero(); ///< of the output, in the clip's world
  double fps = 0;                                   ///< by which frames were chosen; 0: all of them
  bool index = false;                               ///< of volumes: one more file, which shows them in turn
  bool resume = false;                              ///< numbered files that are there stay, and are not made again
  bool strict = false;                              ///< what cannot be carried over is an error instead of a warning
};

/// Whether the format holds all frames in one file; else there is a file for each.
inline bool is_one_file(const KinoraFormat& format) {
  return host::supports(format, KINORA_WRITES_MESHES) && !host::supports(format, KINORA_WRITES_MESH_FRAME);
}

/// Tells of something that the output does not carry as the clip has it: a warning, or Error(kFailure) if strict.
void report_loss(const Conversion& conversion, const std::string& sentence, Context& context);

/// The mesh at another place.
host::Mesh shifted(host::Mesh mesh, const Eigen::Vector3d& by);

/// Tells of frames in which a layer was lost, and of those at which it is not there but shown: not every format can
/// hide a mesh.
void report_lost_frames(const Conversion& conversion, const clip::Layer& layer, Context& context);

/// Tells of a layer that has no surface.
void report_no_surface(const Conversion& conversion, const clip::Layer& layer, Context& context);

/// All layers in one file, with their motion. Returns what was written, for --json: "layers", "files", "bytes".
nlohmann::json convert_to_meshes(const Conversion& conversion, Context& context);

/// One file for each frame: OUT/name_0001.vdb, … Returns the same, with "voxels" of the files.
nlohmann::json convert_to_volumes(const Conversion& conversion, Context& context);

/// One file for each frame with all layers as they are then: OUT/name_0001.ply, … Returns the same as the first.
nlohmann::json convert_to_mesh_sequence(const Conversion& conversion, Context& context);

/// Makes the folder of numbered files, and throws Error(kUnwritableOutput) if one of them is there and must stay, and
/// is not to be kept.
void check_numbered_outputs(const Conversion& conversion, bool overwrite);

/// Whether the file is there and is to be kept.
bool is_done(const Conversion& conversion, const std::filesystem::path& path);

/// "a/b.vdb", 0 → "a/b_0001.vdb".
std::filesystem::path numbered_path(const std::filesystem::path& path, std::size_t index);

} // namespace kinora::cli
