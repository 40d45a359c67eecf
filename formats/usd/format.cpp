#include "usd/format.h"

#include <memory>

#include "common/boundary.h"
#include "common/files.h"
#include "usd/usd_writer.h"

namespace kinora::formats {
namespace {

UsdWriter* self(KinoraWriter* writer) { return reinterpret_cast<UsdWriter*>(writer); }

KinoraStatus open_usd(const char* path, const KinoraOptionValue* options, size_t option_count, KinoraWriter** writer,
                      KinoraMessage* message) {
  return guarded(message, [&] {
    UsdSettings settings;
    const auto given = option_map(options, option_count);
    settings.axes = WorldAxes(given);
    for (const auto& [name, value] : given) {
      const double number = parse_number(value).value_or(-1);
      if (name == "fps") settings.frames_per_second = number;
      if (name == "jpeg") settings.jpeg_quality = static_cast<int>(number);
    }
    if (!(settings.frames_per_second >= 0) || settings.jpeg_quality < 0 || settings.jpeg_quality > 100)
      throw Error(ErrorCode::kUsage, std::string(path) + ": -O fps is 0 or more, and -O jpeg from 0 to 100");
    *writer = reinterpret_cast<KinoraWriter*>(new UsdWriter(path, settings));
    return KINORA_OK;
  });
}

KinoraStatus facts_usd(KinoraWriter* writer, const KinoraOptionValue* facts, size_t count, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->describe(facts_of(facts, count));
    return KINORA_OK;
  });
}

KinoraStatus mesh_usd(KinoraWriter* writer, const KinoraMesh* mesh, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->add(*mesh);
    return KINORA_OK;
  });
}

KinoraStatus pose_usd(KinoraWriter* writer, const KinoraMeshPose* pose, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->pose(*pose);
    return KINORA_OK;
  });
}

KinoraStatus finish_usd(KinoraWriter* writer, KinoraMessage* message) {
  const std::unique_ptr<UsdWriter> owned(self(writer));
  return guarded(message, [&] {
    owned->finish();
    return KINORA_OK;
  });
}

void abandon_usd(KinoraWriter* writer) { delete self(writer); }

const KinoraOption kOptions[] = {
    {"fps", "number", "0", "Time codes per second; 0: one for each frame that is written.", nullptr},
    {"jpeg", "int", "92", "Quality of textures as JPEG, 1 to 100; 0 keeps them as they are, as PNG.", nullptr},
    kUpOption,
    kUnitsOption};

constexpr KinoraFormat usd_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "usd";
  format.description = "USD text: a mesh per layer with time samples, and its texture beside the file";
  format.extensions = ".usda";
  format.capabilities =
      KINORA_WRITES_MESHES | KINORA_WRITES_SKINS | KINORA_WRITES_TEXTURES | KINORA_WRITES_FILES_BESIDE;
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  format.open_writer = open_usd;
  format.writer_finish = finish_usd;
  format.writer_abandon = abandon_usd;
  format.writer_mesh = mesh_usd;
  format.writer_pose = pose_usd;
  format.writer_facts = facts_usd;
  return format;
}

} // namespace

constinit const KinoraFormat kUsdFormat = usd_format();

} // namespace kinora::formats
