#include "obj/format.h"

#include <iterator>

#include "common/writers.h"
#include "obj/obj_writer.h"

namespace kinora::formats {
namespace {

std::unique_ptr<ObjWriter> open_obj(const char* path, const OptionMap& options) {
  return std::make_unique<ObjWriter>(path, WorldAxes(options));
}

const KinoraOption kOptions[] = {kUpOption, kUnitsOption};

constexpr KinoraFormat obj_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "obj";
  format.description = "Wavefront OBJ of one time: an object per layer with normals and vertex colours";
  format.extensions = ".obj";
  format.capabilities = KINORA_WRITES_MESHES | KINORA_WRITES_MESH_FRAME;
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  set_mesh_writer<ObjWriter, open_obj>(format);
  return format;
}

} // namespace

constinit const KinoraFormat kObjFormat = obj_format();

} // namespace kinora::formats
