#include "common/deferred.h"

#include <system_error>

#include "core/module.h"

namespace kinora::formats {
namespace {

/// A writer of the module's format.
struct DeferredWriter {
  const KinoraFormat& format;
  KinoraWriter* writer;
};

DeferredWriter* self(KinoraWriter* writer) { return reinterpret_cast<DeferredWriter*>(writer); }

const KinoraFormat& format_of(const FormatModule& module) {
  const auto entry =
      reinterpret_cast<KinoraPluginEntry>(module_symbol(module.name, KINORA_PLUGIN_ENTRY, module.purpose));
  const KinoraPlugin* plugin = entry(KINORA_PLUGIN_ABI);
  if (plugin == nullptr || plugin->format_count != 1)
    throw Error(ErrorCode::kMissingComponent, module_path(module.name).string() +
                                                  " belongs to another version of Kinora; install the program and its "
                                                  "modules together");
  return *plugin->formats[0];
}

} // namespace

KinoraStatus open_deferred(const FormatModule& module, const char* path, const KinoraOptionValue* options,
                           std::size_t option_count, KinoraWriter** writer, KinoraMessage* message) {
  return guarded(message, [&] {
    const KinoraFormat& format = format_of(module);
    auto deferred = std::make_unique<DeferredWriter>(DeferredWriter{format, nullptr});
    const KinoraStatus status = format.open_writer(path, options, option_count, &deferred->writer, message);
    if (status == KINORA_OK) *writer = reinterpret_cast<KinoraWriter*>(deferred.release());
    return status;
  });
}

KinoraStatus write_deferred(KinoraWriter* writer, const KinoraPicture* picture, KinoraMessage* message) {
  return self(writer)->format.writer_write(self(writer)->writer, picture, message);
}

KinoraStatus volume_deferred(KinoraWriter* writer, const KinoraVolume* volume, KinoraMessage* message) {
  return self(writer)->format.writer_volume(self(writer)->writer, volume, message);
}

KinoraStatus facts_deferred(KinoraWriter* writer, const KinoraOptionValue* facts, std::size_t count,
                            KinoraMessage* message) {
  const KinoraFormat& format = self(writer)->format;
  return format.writer_facts == nullptr ? KINORA_OK : format.writer_facts(self(writer)->writer, facts, count, message);
}

KinoraStatus finish_deferred(KinoraWriter* writer, KinoraMessage* message) {
  const std::unique_ptr<DeferredWriter> owned(self(writer));
  return owned->format.writer_finish(owned->writer, message);
}

void abandon_deferred(KinoraWriter* writer) {
  const std::unique_ptr<DeferredWriter> owned(self(writer));
  owned->format.writer_abandon(owned->writer);
}

std::string deferred_description(const FormatModule& module, const char* description) {
  const std::filesystem::path path = module_path(module.name);
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored)) return description;
  return std::string(description) + " (not available: " + path.string() + " is not installed)";
}

} // namespace kinora::formats
