// A format whose work is done in a module (core/module.h), which is opened when something is first read or written.
#pragma once

#include "common/boundary.h"

namespace kinora::formats {

/// The module is itself a plugin: it exports kinora_plugin (module_plugin.h).
struct FormatModule {
  const char* name;
  const char* format;  ///< one of the module's
  const char* purpose; ///< for the error where it is missing: "to write MP4 films"
};

/// The format with its functions; the module stays open. Throws Error(kMissingComponent).
const KinoraFormat& format_in(const FormatModule& module);

/// The description; where the module is not installed, with a word about that.
std::string deferred_description(const FormatModule& module, const char* description);

/// As format_in, found once.
template <const FormatModule& module> const KinoraFormat& opened_format() {
  static const KinoraFormat& format = format_in(module);
  return format;
}

/// A format from its description, which has no functions but `probe`. Where its module is missing, opening a reader or
/// a writer fails with KINORA_MISSING.
template <const FormatModule& module> KinoraFormat deferred_format(KinoraFormat format) {
  static const std::string description = deferred_description(module, format.description);
  format.description = description.c_str();
  if ((format.capabilities & KINORA_READS_FRAMES) != 0) {
    format.open_reader = [](const char* path, const KinoraOptionValue* options, std::size_t option_count,
                            KinoraReader** reader, KinoraMessage* message) {
      return guarded(message,
                     [&] { return opened_format<module>().open_reader(path, options, option_count, reader, message); });
    };
    format.reader_info = [](auto... given) { return opened_format<module>().reader_info(given...); };
    format.reader_next = [](auto... given) { return opened_format<module>().reader_next(given...); };
    format.reader_close = [](auto... given) { return opened_format<module>().reader_close(given...); };
  }
  if ((format.capabilities & KINORA_SEEKS) != 0)
    format.reader_seek = [](auto... given) { return opened_format<module>().reader_seek(given...); };
  if ((format.capabilities & (KINORA_WRITES_FRAMES | KINORA_WRITES_PICTURES | KINORA_WRITES_VOLUMES)) == 0)
    return format;
  format.open_writer = [](const char* path, const KinoraOptionValue* options, std::size_t option_count,
                          KinoraWriter** writer, KinoraMessage* message) {
    return guarded(message,
                   [&] { return opened_format<module>().open_writer(path, options, option_count, writer, message); });
  };
  format.writer_finish = [](auto... given) { return opened_format<module>().writer_finish(given...); };
  format.writer_abandon = [](auto... given) { return opened_format<module>().writer_abandon(given...); };
  if ((format.capabilities & KINORA_WRITES_PICTURES) != 0)
    format.writer_write = [](auto... given) { return opened_format<module>().writer_write(given...); };
  if ((format.capabilities & KINORA_WRITES_VOLUMES) != 0)
    format.writer_volume = [](auto... given) { return opened_format<module>().writer_volume(given...); };
  if ((format.capabilities & KINORA_WRITES_VOLUME_INDEX) != 0)
    format.write_volume_index = [](const char* path, const KinoraOptionValue* options, std::size_t option_count,
                                   const KinoraVolumeSequence* sequence, KinoraMessage* message) {
      return guarded(message, [&] {
        return opened_format<module>().write_volume_index(path, options, option_count, sequence, message);
      });
    };
  if ((format.capabilities & KINORA_WRITES_FRAMES) != 0) {
    format.writer_capture = [](auto... given) { return opened_format<module>().writer_capture(given...); };
    format.writer_frame = [](auto... given) { return opened_format<module>().writer_frame(given...); };
  }
  format.writer_facts = [](KinoraWriter* writer, const KinoraOptionValue* facts, std::size_t count,
                           KinoraMessage* message) {
    const KinoraFormat& opened = opened_format<module>();
    return opened.writer_facts == nullptr ? KINORA_OK : opened.writer_facts(writer, facts, count, message);
  };
  return format;
}

/// As deferred_format, of live cameras.
template <const FormatModule& module> KinoraFormat deferred_camera(KinoraFormat format) {
  format.probe = [](const char* /*path*/, KinoraProbe* answer) {
    answer_probe(answer, 0, std::string("no file, but a camera: name it ").append(module.format).append(":0"));
  };
  return deferred_format<module>(format);
}

} // namespace kinora::formats
