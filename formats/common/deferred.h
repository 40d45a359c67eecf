// A format whose work is done in a module (core/module.h), which is opened when something is first written.
#pragma once

#include "common/boundary.h"

namespace kinora::formats {

/// The module is itself a plugin: it exports kinora_plugin, with this one format.
struct FormatModule {
  const char* name;
  const char* purpose; ///< for the error where it is missing: "to write MP4 films"
};

/// The functions of a writer, handed on to the module's format.
KinoraStatus open_deferred(const FormatModule& module, const char* path, const KinoraOptionValue* options,
                           std::size_t option_count, KinoraWriter** writer, KinoraMessage* message);
KinoraStatus write_deferred(KinoraWriter* writer, const KinoraPicture* picture, KinoraMessage* message);
KinoraStatus volume_deferred(KinoraWriter* writer, const KinoraVolume* volume, KinoraMessage* message);
KinoraStatus facts_deferred(KinoraWriter* writer, const KinoraOptionValue* facts, std::size_t count,
                            KinoraMessage* message);
KinoraStatus finish_deferred(KinoraWriter* writer, KinoraMessage* message);
void abandon_deferred(KinoraWriter* writer);

/// The description; where the module is not installed, with a word about that.
std::string deferred_description(const FormatModule& module, const char* description);

/// A format that writes pictures or volumes, from its description without functions. Where its module is missing,
/// open_writer fails with KINORA_MISSING.
template <const FormatModule& module> KinoraFormat deferred_format(KinoraFormat format) {
  static const std::string description = deferred_description(module, format.description);
  format.description = description.c_str();
  format.open_writer = [](const char* path, const KinoraOptionValue* options, std::size_t option_count,
                          KinoraWriter** writer, KinoraMessage* message) {
    return open_deferred(module, path, options, option_count, writer, message);
  };
  if ((format.capabilities & KINORA_WRITES_PICTURES) != 0) format.writer_write = write_deferred;
  if ((format.capabilities & KINORA_WRITES_VOLUMES) != 0) format.writer_volume = volume_deferred;
  format.writer_facts = facts_deferred;
  format.writer_finish = finish_deferred;
  format.writer_abandon = abandon_deferred;
  return format;
}

} // namespace kinora::formats
