#include "gltf/format.h"

#include "common/boundary.h"
#include "gltf/glb_writer.h"
#include "gltf/principal_shapes.h"

namespace kinora::formats {
namespace {

GlbWriter* self(KinoraWriter* writer) { return reinterpret_cast<GlbWriter*>(writer); }

std::size_t shapes_of(const std::string& text) {
  const int count = std::stoi(text);
  if (count >= 1 && count <= static_cast<int>(kMaxShapes)) return static_cast<std::size_t>(count);
  throw Error(ErrorCode::kUsage, "-O shapes=" + text + ": there may be 1 to " + std::to_string(kMaxShapes));
}

KinoraStatus open_glb(const char* path, const KinoraOptionValue* options, size_t option_count, KinoraWriter** writer,
                      KinoraMessage* message) {
  return guarded(message, [&] {
    const auto given = option_map(options, option_count);
    const auto value = [&given](const char* name) {
      const auto found = given.find(name);
      return found == given.end() ? std::string() : found->second;
    };
    GlbSettings settings;
    if (value("interpolation") == "step") settings.interpolation = Interpolation::kStep;
    if (value("compression") == "meshopt") settings.compression = Compression::kMeshopt;
    if (value("compression") == "draco") settings.compression = Compression::kDraco;
    if (value("animation") == "morph") settings.bending = Bending::kMorph;
    if (value("animation") == "sequence") settings.bending = Bending::kSequence;
    if (const std::string shapes = value("shapes"); !shapes.empty()) settings.max_shapes = shapes_of(shapes);
    settings.quantize = value("quantize") != "false";
    if (const std::string quality = value("jpeg"); !quality.empty()) settings.jpeg_quality = std::stoi(quality);
    if (settings.jpeg_quality < 0 || settings.jpeg_quality > 100)
      throw Error(ErrorCode::kUsage, "-O jpeg=" + value("jpeg") + ": the quality is 1 to 100, or 0 for PNG");
    *writer = reinterpret_cast<KinoraWriter*>(new GlbWriter(path, settings));
    return KINORA_OK;
  });
}

KinoraStatus facts_glb(KinoraWriter* writer, const KinoraOptionValue* facts, size_t count, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->describe(facts_of(facts, count));
    return KINORA_OK;
  });
}

KinoraStatus mesh_glb(KinoraWriter* writer, const KinoraMesh* mesh, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->add(*mesh);
    return KINORA_OK;
  });
}

KinoraStatus pose_glb(KinoraWriter* writer, const KinoraMeshPose* pose, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->pose(*pose);
    return KINORA_OK;
  });
}

KinoraStatus finish_glb(KinoraWriter* writer, KinoraMessage* message) {
  const std::unique_ptr<GlbWriter> owned(self(writer));
  return guarded(message, [&] {
    owned->finish();
    return KINORA_OK;
  });
}

void abandon_glb(KinoraWriter* writer) { delete self(writer); }

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
  format.capabilities = KINORA_WRITES_MESHES | KINORA_WRITES_SKINS | KINORA_WRITES_TEXTURES;
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  format.open_writer = open_glb;
  format.writer_finish = finish_glb;
  format.writer_abandon = abandon_glb;
  format.writer_mesh = mesh_glb;
  format.writer_pose = pose_glb;
  format.writer_facts = facts_glb;
  return format;
}

} // namespace

constinit const KinoraFormat kGltfFormat = glb_format();

} // namespace kinora::formats
