#include "obj/format.h"

#include <memory>

#include "common/boundary.h"
#include "obj/obj_writer.h"

namespace kinora::formats {
namespace {

ObjWriter* self(KinoraWriter* writer) { return reinterpret_cast<ObjWriter*>(writer); }

KinoraStatus open_obj(const char* path, const KinoraOptionValue* /*options*/, size_t /*option_count*/,
                      KinoraWriter** writer, KinoraMessage* message) {
  return guarded(message, [&] {
    *writer = reinterpret_cast<KinoraWriter*>(new ObjWriter(path));
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

constexpr KinoraFormat obj_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "obj";
  format.description = "Wavefront OBJ of one time: an object per layer with normals and vertex colours";
  format.extensions = ".obj";
  format.capabilities = KINORA_WRITES_MESHES | KINORA_WRITES_MESH_FRAME;
  format.open_writer = open_obj;
  format.writer_finish = finish_obj;
  format.writer_abandon = abandon_obj;
  format.writer_mesh = mesh_obj;
  return format;
}

} // namespace

constinit const KinoraFormat kObjFormat = obj_format();

} // namespace kinora::formats
