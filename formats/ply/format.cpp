#include "ply/format.h"

#include <iterator>
#include <memory>

#include "common/boundary.h"
#include "ply/ply_writer.h"

namespace kinora::formats {
namespace {

PlyWriter* self(KinoraWriter* writer) { return reinterpret_cast<PlyWriter*>(writer); }

PlyContent content_called(const std::string& name) {
  if (name == "points") return PlyContent::kPoints;
  return name == "splats" ? PlyContent::kSplats : PlyContent::kMesh;
}

KinoraStatus open_ply(const char* path, const KinoraOptionValue* options, size_t option_count, KinoraWriter** writer,
                      KinoraMessage* message) {
  return guarded(message, [&] {
    const auto given = option_map(options, option_count);
    const auto content = given.find("content");
    *writer = reinterpret_cast<KinoraWriter*>(new PlyWriter(
        path, content == given.end() ? PlyContent::kMesh : content_called(content->second), WorldAxes(given)));
    return KINORA_OK;
  });
}

KinoraStatus facts_ply(KinoraWriter* writer, const KinoraOptionValue* facts, size_t count, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->describe(facts_of(facts, count));
    return KINORA_OK;
  });
}

KinoraStatus mesh_ply(KinoraWriter* writer, const KinoraMesh* mesh, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->add(*mesh);
    return KINORA_OK;
  });
}

KinoraStatus finish_ply(KinoraWriter* writer, KinoraMessage* message) {
  const std::unique_ptr<PlyWriter> owned(self(writer));
  return guarded(message, [&] {
    owned->finish();
    return KINORA_OK;
  });
}

void abandon_ply(KinoraWriter* writer) { delete self(writer); }

const KinoraOption kOptions[] = {
    {"content", "mesh|points|splats", "mesh",
     "Triangles with colours in their vertices, the vertices alone, or a Gaussian splat for each, with y down and "
     "metres in any case.",
     nullptr},
    kUpOption,
    kUnitsOption};

constexpr KinoraFormat ply_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "ply";
  format.description =
      "Binary PLY of one time: all layers as triangles with vertex colours, as points, or as Gaussian splats";
  format.extensions = ".ply";
  format.capabilities = KINORA_WRITES_MESHES | KINORA_WRITES_MESH_FRAME;
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  format.open_writer = open_ply;
  format.writer_finish = finish_ply;
  format.writer_abandon = abandon_ply;
  format.writer_mesh = mesh_ply;
  format.writer_facts = facts_ply;
  return format;
}

} // namespace

constinit const KinoraFormat kPlyFormat = ply_format();

} // namespace kinora::formats
