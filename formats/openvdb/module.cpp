// The module openvdb: a plugin of one format.
#include "openvdb/description.h"
#include "openvdb/vdb_writer.h"

namespace kinora::formats {
namespace {

VdbWriter* self(KinoraWriter* writer) { return reinterpret_cast<VdbWriter*>(writer); }

KinoraStatus open_vdb(const char* path, const KinoraOptionValue* options, size_t option_count, KinoraWriter** writer,
                      KinoraMessage* message) {
  return guarded(message, [&] {
    const auto given = option_map(options, option_count);
    const auto precision = given.find("precision");
    const bool half = precision == given.end() || precision->second == "half";
    *writer = reinterpret_cast<KinoraWriter*>(new VdbWriter(path, half));
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
