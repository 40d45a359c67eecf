#include "gltf/format.h"

#include "common/writers.h"
#include "gltf/glb_writer.h"
#include "gltf/principal_shapes.h"

namespace kinora::formats {
namespace {

std::size_t shapes_of(const std::string& text) {
  const int count = std::stoi(text);
  if (count >= 1 && count <= static_cast<int>(kMaxShapes)) return static_cast<std::size_t>(count);
  throw Error(ErrorCode::kUsage, "-O shapes=" + text + ": there may be 1 to " + std::to_string(kMaxShapes));
}

std::unique_ptr<GlbWriter> open_glb(const char* path, const OptionMap& options) {
  GlbSettings settings;
  const std::string compression = option_text(options, "compression");
  const std::string animation = option_text(options, "animation");
  if (option_text(options, "interpolation") == "step") settings.interpolation = Interpolation::kStep;
  if (compression == "meshopt") settings.compression = Compression::kMeshopt;
  if (compression == "draco") settings.compression = Compression::kDraco;
  if (animation == "morph") settings.bending = Bending::kMorph;
  if (animation == "sequence") settings.bending = Bending::kSequence;
  if (const std::string shapes = option_text(options, "shapes"); !shapes.empty())
    settings.max_shapes = shapes_of(shapes);
  settings.quantize = option_is_set(options, "quantize", true);
  settings.jpeg_quality = static_cast<int>(option_number(options, "jpeg", settings.jpeg_quality));
  if (settings.jpeg_quality < 0 || settings.jpeg_quality > 100)
    throw Error(ErrorCode::kUsage,
                "-O jpeg=" + option_text(options, "jpeg") + ": the quality is 1 to 100, or 0 for PNG");
  return std::make_unique<GlbWriter>(path, settings);
}

const KinoraOption kOptions[] = {
    {"interpolation", "linear|step", "linear", "Between two frames: move evenly, or hold the pose of the earlier one.",
     nullptr},
    {"animation", "skin|morph|sequence", "skin",
     "What bends: a skin on many joints; shapes that are mixed (morph targets); or a mesh for each frame.", nullptr},
    {"shapes", "int", "24", "Of animation=morph: at most so many shapes, 1 to 64.", nullptr},
    {"compression", "none|meshopt|draco", "none",
     "Smaller files for viewers that can unpack them: meshopt packs geometry and animation, draco geometry.", nullptr},
    {"quantize", "bool", "true", "Positions, texture coordinates and rotations as 16-bit numbers, half the size.",
     nullptr},
    {"jpeg", "int", "88", "Quality of textures as JPEG, 1 to 100; 0 keeps them as they are, as PNG.", nullptr}};

constexpr KinoraFormat glb_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "glb";
  format.description =
      "glTF 2.0 in one binary file: a mesh per layer with a texture or vertex colours, skins and animation";
  format.extensions = ".glb";
  format.capabilities = KINORA_WRITES_MESHES | KINORA_WRITES_SKINS | KINORA_WRITES_TEXTURES | KINORA_WRITES_HIDDEN;
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  set_mesh_writer<GlbWriter, open_glb>(format);
  return format;
}

} // namespace

constinit const KinoraFormat kGltfFormat = glb_format();

} // namespace kinora::formats
