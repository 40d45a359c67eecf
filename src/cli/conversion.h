// A clip turned into what a format plugin writes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bake/mesh_extraction.h"
#include "bake/volume.h"
#include "cli/context.h"
#include "clip/layer_choice.h"
#include "host/options.h"

namespace kinora::cli {

/// What to convert, and into what.
struct Conversion {
  const clip::Clip* clip = nullptr;
  const KinoraFormat* format = nullptr;
  std::filesystem::path input;
  std::filesystem::path output;
  std::vector<int> frames; ///< of the clip, increasing
  clip::LayerChoice layers;
  bake::MeshExtractionOptions surface;
  bake::VolumeOptions volume;
  host::Options format_options;
  bool strict = false; ///< what cannot be carried over is an error instead of a warning
};

/// Tells of something that the output does not carry as the clip has it: a warning, or Error(kFailure) if strict.
void report_loss(const Conversion& conversion, const std::string& sentence, Context& context);

/// Tells of frames in which a layer was lost.
void report_lost_frames(const Conversion& conversion, const clip::Layer& layer, Context& context);

/// Tells of a layer that has no surface.
void report_no_surface(const Conversion& conversion, const clip::Layer& layer, Context& context);

/// All layers in one file, with their motion. Returns what was written, for --json: "layers", "files", "bytes".
nlohmann::json convert_to_meshes(const Conversion& conversion, Context& context);

/// One file for each frame: OUT/name_0001.vdb, … Returns the same, with "voxels" of the files.
nlohmann::json convert_to_volumes(const Conversion& conversion, Context& context);

/// One file for each frame with all layers as they are then: OUT/name_0001.ply, … Returns the same as the first.
nlohmann::json convert_to_mesh_sequence(const Conversion& conversion, Context& context);

/// Makes the folder of numbered files, and throws Error(kUnwritableOutput) if one of them is there and must stay.
void check_numbered_outputs(const Conversion& conversion, bool overwrite);

/// "a/b.vdb", 0 → "a/b_0001.vdb".
std::filesystem::path numbered_path(const std::filesystem::path& path, std::size_t index);

} // namespace kinora::cli
