#include "ply/format.h"

#include <iterator>
#include <memory>

#include "common/boundary.h"
#include "ply/ply_writer.h"

namespace kinora::formats {
namespace {

PlyWriter* self(KinoraWriter* writer) { return reinterpret_cast<PlyWriter*>(writer); }

KinoraStatus open_ply(const char* path, const KinoraOptionValue* options, size_t option_count, KinoraWriter** writer,
                      KinoraMessage* message) {
  return guarded(message, [&] {
    const auto given = option_map(options, option_count);
    const auto content = given.find("content");
    const bool points = content != given.end() && content->second == "points";
    *writer = reinterpret_cast<KinoraWriter*>(new PlyWriter(path, points ? PlyContent::kPoints : PlyContent::kMesh));
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
    {"content", "mesh|points", "mesh", "Triangles with colours in their vertices, or the vertices alone.", nullptr}};

constexpr KinoraFormat ply_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "ply";
  format.description = "Binary PLY of one time: all layers as triangles with vertex colours, or as points";
  format.extensions = ".ply";
  format.capabilities = KINORA_WRITES_MESHES | KINORA_WRITES_MESH_FRAME;
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  format.open_writer = open_ply;
  format.writer_finish = finish_ply;
  format.writer_abandon = abandon_ply;
  format.writer_mesh = mesh_ply;
  return format;
}

} // namespace

constinit const KinoraFormat kPlyFormat = ply_format();

} // namespace kinora::formats
