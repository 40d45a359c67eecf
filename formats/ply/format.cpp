#include "ply/format.h"

#include <iterator>

#include "common/writers.h"
#include "ply/ply_writer.h"

namespace kinora::formats {
namespace {

PlyContent content_called(const std::string& name) {
  if (name == "points") return PlyContent::kPoints;
  return name == "splats" ? PlyContent::kSplats : PlyContent::kMesh;
}

std::unique_ptr<PlyWriter> open_ply(const char* path, const OptionMap& options) {
  return std::make_unique<PlyWriter>(path, content_called(option_text(options, "content")), WorldAxes(options));
}

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
  set_mesh_writer<PlyWriter, open_ply>(format);
  return format;
}

} // namespace

constinit const KinoraFormat kPlyFormat = ply_format();

} // namespace kinora::formats
