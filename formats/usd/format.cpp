#include "usd/format.h"

#include "common/writers.h"
#include "usd/usd_writer.h"

namespace kinora::formats {
namespace {

std::unique_ptr<UsdWriter> open_usd(const char* path, const OptionMap& options) {
  UsdSettings settings;
  settings.axes = WorldAxes(options);
  settings.frames_per_second = option_number(options, "fps", settings.frames_per_second);
  settings.jpeg_quality = static_cast<int>(option_number(options, "jpeg", settings.jpeg_quality));
  if (!(settings.frames_per_second >= 0) || settings.jpeg_quality < 0 || settings.jpeg_quality > 100)
    throw Error(ErrorCode::kUsage, std::string(path) + ": -O fps is 0 or more, and -O jpeg from 0 to 100");
  return std::make_unique<UsdWriter>(path, settings);
}

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
  format.capabilities = KINORA_WRITES_MESHES | KINORA_WRITES_SKINS | KINORA_WRITES_TEXTURES |
                        KINORA_WRITES_FILES_BESIDE | KINORA_WRITES_HIDDEN;
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  set_mesh_writer<UsdWriter, open_usd>(format);
  return format;
}

} // namespace

constinit const KinoraFormat kUsdFormat = usd_format();

} // namespace kinora::formats
