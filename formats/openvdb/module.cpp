// The module openvdb: a plugin of one format.
#include "common/module_plugin.h"
#include "common/writers.h"
#include "openvdb/description.h"
#include "openvdb/usd_volume.h"
#include "openvdb/vdb_writer.h"

namespace kinora::formats {
namespace {

VdbNames names_for(const std::string& program) {
  if (program == "blender") return kBlenderNames;
  return program == "unreal" ? kUnrealNames : kHoudiniNames;
}

VdbSettings settings_of(const OptionMap& options) {
  const std::string content = option_text(options, "content");
  VdbSettings settings;
  settings.half_floats = option_text(options, "precision") != "float";
  settings.fog = content != "surface";
  settings.surface = content == "surface" || content == "both";
  settings.names = names_for(option_text(options, "vdb-names"));
  settings.axes = WorldAxes(options);
  return settings;
}

std::unique_ptr<VdbWriter> open_vdb(const char* path, const OptionMap& options) {
  return std::make_unique<VdbWriter>(path, settings_of(options));
}

constexpr KinoraFormat module_format() {
  KinoraFormat format = openvdb_description();
  set_volume_writer<VdbWriter, open_vdb>(format);
  format.write_volume_index = [](const char* path, const KinoraOptionValue* options, std::size_t option_count,
                                 const KinoraVolumeSequence* sequence, KinoraMessage* message) {
    return guarded(message, [&] {
      write_usd_volume(path, *sequence, settings_of(option_map(options, option_count)));
      return KinoraStatus{KINORA_OK};
    });
  };
  return format;
}

constexpr KinoraFormat kFormat = module_format();

} // namespace
} // namespace kinora::formats

extern "C" const KinoraPlugin* kinora_plugin(std::uint32_t host_abi_version) {
  return kinora::formats::module_plugin<kinora::formats::kFormat>(host_abi_version);
}
