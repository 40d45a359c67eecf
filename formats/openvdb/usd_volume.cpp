#include "openvdb/usd_volume.h"

#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "common/files.h"
#include "common/number_text.h"
#include "common/usd_layer.h"

namespace kinora::formats {
namespace {

/// How USD describes a grid.
struct Field {
  const char* name;
  const char* type; ///< of numbers, without "half" or "float"
  const char* more; ///< further attributes
};

std::vector<Field> fields_of(const VdbSettings& settings) {
  std::vector<Field> fields;
  if (settings.fog) fields.push_back({settings.names.density, "", "        token fieldClass = \"fogVolume\"\n"});
  if (settings.surface) fields.push_back({settings.names.surface, "", "        token fieldClass = \"levelSet\"\n"});
  fields.push_back({settings.names.color, "3", "        token vectorDataRoleHint = \"Color\"\n"});
  return fields;
}

/// The box in the file's axes and lengths: "[(x, y, z), (x, y, z)]".
std::string extent_of(const KinoraVolumeFile& file, const WorldAxes& axes) {
  const Eigen::AlignedBox3d world(Eigen::Vector3d(file.low[0], file.low[1], file.low[2]),
                                  Eigen::Vector3d(file.high[0], file.high[1], file.high[2]));
  Eigen::AlignedBox3d box;
  for (int k = 0; k < 8; ++k)
    box.extend(axes.per_metre * axes.rotation() * world.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k)));
  constexpr int kDecimals = 4;
  std::string text = "[";
  for (const Eigen::Vector3d& corner : {box.min(), box.max()}) {
    text += text.size() > 1 ? ", (" : "(";
    for (int i = 0; i < 3; ++i) {
      if (i > 0) text += ", ";
      append_number(text, corner[i], kDecimals);
    }
    text += ")";
  }
  return text + "]";
}

std::string field_prim(const Field& field, const std::string& samples, const VdbSettings& settings) {
  const std::string name = field.name;
  return "\n        def OpenVDBAsset \"" + name + "\"\n        {\n    " + field.more +
         "            token fieldDataType = \"" + (settings.half_floats ? "half" : "float") + field.type +
         "\"\n            token fieldName = \"" + name + "\"\n            asset filePath.timeSamples = {\n" + samples +
         "            }\n        }\n";
}

} // namespace

void write_usd_volume(const std::filesystem::path& path, const KinoraVolumeSequence& sequence,
                      const VdbSettings& settings) {
  const std::span files(sequence.files, sequence.file_count);
  UsdLayer layer{sequence.frames_per_second, files.back().time, settings.axes,
                 facts_of(sequence.facts, sequence.fact_count)};
  std::string extents;
  std::string samples;
  for (const KinoraVolumeFile& file : files) {
    const std::string time = usd_time_code(file.time, layer.rate);
    samples += "                " + time + ": @@@./" + file.name + "@@@,\n";
    if (file.low[0] <= file.high[0]) extents += "            " + time + ": " + extent_of(file, settings.axes) + ",\n";
  }
  std::string text = usd_layer_head(layer);
  text += "def Xform \"clip\" (\n    kind = \"component\"\n)\n{\n    def Volume \"volume\"\n    {\n";
  if (!extents.empty()) text += "        float3[] extent.timeSamples = {\n" + extents + "        }\n";
  std::string prims;
  for (const Field& field : fields_of(settings)) {
    text += std::string("        rel field:") + field.name + " = </clip/volume/" + field.name + ">\n";
    prims += field_prim(field, samples, settings);
  }
  text += prims + "    }\n}\n";
  write_file(path, std::as_bytes(std::span(text)));
}

} // namespace kinora::formats
