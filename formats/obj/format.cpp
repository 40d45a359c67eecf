#include "obj/format.h"

#include <iterator>
#include <memory>

#include "common/boundary.h"
#include "obj/obj_writer.h"

namespace kinora::formats {
namespace {

ObjWriter* self(KinoraWriter* writer) { return reinterpret_cast<ObjWriter*>(writer); }

KinoraStatus open_obj(const char* path, const KinoraOptionValue* options, size_t option_count, KinoraWriter** writer,
                      KinoraMessage* message) {
  return guarded(message, [&] {
    *writer = reinterpret_cast<KinoraWriter*>(new ObjWriter(path, WorldAxes(option_map(options, option_count))));
    return KINORA_OK;
  });
}

KinoraStatus facts_obj(KinoraWriter* writer, const KinoraOptionValue* facts, size_t count, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->describe(facts_of(facts, count));
    return KINORA_OK;
  });
}

KinoraStatus mesh_obj(KinoraWriter* writer, const KinoraMesh* mesh, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->add(*mesh);
    return KINORA_OK;
  });
}

KinoraStatus finish_obj(KinoraWriter* writer, KinoraMessage* message) {
  const std::unique_ptr<ObjWriter> owned(self(writer));
  return guarded(message, [&] {
    owned->finish();
    return KINORA_OK;
  });
}

void abandon_obj(KinoraWriter* writer) { delete self(writer); }

const KinoraOption kOptions[] = {kUpOption, kUnitsOption};

constexpr KinoraFormat obj_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "obj";
  format.description = "Wavefront OBJ of one time: an object per layer with normals and vertex colours";
  format.extensions = ".obj";
  format.capabilities = KINORA_WRITES_MESHES | KINORA_WRITES_MESH_FRAME;
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  format.open_writer = open_obj;
  format.writer_finish = finish_obj;
  format.writer_abandon = abandon_obj;
  format.writer_mesh = mesh_obj;
  format.writer_facts = facts_obj;
  return format;
}

} // namespace

constinit const KinoraFormat kObjFormat = obj_format();

} // namespace kinora::formats
