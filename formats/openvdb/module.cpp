// The module openvdb: a plugin of one format.
#include "openvdb/description.h"
#include "openvdb/vdb_writer.h"

namespace kinora::formats {
namespace {

VdbWriter* self(KinoraWriter* writer) { return reinterpret_cast<VdbWriter*>(writer); }

VdbNames names_for(const std::string& program) {
  if (program == "blender") return kBlenderNames;
  return program == "unreal" ? kUnrealNames : kHoudiniNames;
}

VdbSettings settings_of(const std::map<std::string, std::string>& given) {
  const auto value = [&given](const char* name) {
    const auto found = given.find(name);
    return found == given.end() ? std::string() : found->second;
  };
  VdbSettings settings;
  settings.half_floats = value("precision") != "float";
  settings.fog = value("content") != "surface";
  settings.surface = value("content") == "surface" || value("content") == "both";
  settings.names = names_for(value("vdb-names"));
  settings.axes = WorldAxes(given);
  return settings;
}

KinoraStatus open_vdb(const char* path, const KinoraOptionValue* options, size_t option_count, KinoraWriter** writer,
                      KinoraMessage* message) {
  return guarded(message, [&] {
    *writer = reinterpret_cast<KinoraWriter*>(new VdbWriter(path, settings_of(option_map(options, option_count))));
    return KINORA_OK;
  });
}

KinoraStatus facts_vdb(KinoraWriter* writer, const KinoraOptionValue* facts, size_t count, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->describe(facts_of(facts, count));
    return KINORA_OK;
  });
}

KinoraStatus volume_vdb(KinoraWriter* writer, const KinoraVolume* volume, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->write(*volume);
    return KINORA_OK;
  });
}

KinoraStatus finish_vdb(KinoraWriter* writer, KinoraMessage* message) {
  const std::unique_ptr<VdbWriter> owned(self(writer));
  return guarded(message, [&] {
    owned->finish();
    return KINORA_OK;
  });
}

void abandon_vdb(KinoraWriter* writer) { delete self(writer); }

constexpr KinoraFormat module_format() {
  KinoraFormat format = openvdb_description();
  format.open_writer = open_vdb;
  format.writer_volume = volume_vdb;
  format.writer_facts = facts_vdb;
  format.writer_finish = finish_vdb;
  format.writer_abandon = abandon_vdb;
  return format;
}

constexpr KinoraFormat kFormat = module_format();

} // namespace
} // namespace kinora::formats

extern "C" const KinoraPlugin* kinora_plugin(std::uint32_t host_abi_version) {
  static const KinoraFormat* const formats[] = {&kinora::formats::kFormat};
  static const KinoraPlugin plugin = {sizeof(KinoraPlugin), KINORA_PLUGIN_ABI, "openvdb", "", formats, 1};
  return host_abi_version == KINORA_PLUGIN_ABI ? &plugin : nullptr;
}
