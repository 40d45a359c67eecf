// The module mp4: a plugin of one format.
#include "common/boundary.h"
#include "mp4/description.h"
#include "mp4/mp4_writer.h"

namespace kinora::formats {
namespace {

Mp4Writer* self(KinoraWriter* writer) { return reinterpret_cast<Mp4Writer*>(writer); }

KinoraStatus open_mp4(const char* path, const KinoraOptionValue* options, size_t option_count, KinoraWriter** writer,
                      KinoraMessage* message) {
  return guarded(message, [&] {
    const auto given = option_map(options, option_count);
    Mp4Settings settings;
    if (const auto fps = given.find("fps"); fps != given.end()) settings.frames_per_second = std::stod(fps->second);
    if (const auto crf = given.find("crf"); crf != given.end()) settings.crf = std::stoi(crf->second);
    *writer = reinterpret_cast<KinoraWriter*>(new Mp4Writer(path, settings));
    return KINORA_OK;
  });
}

KinoraStatus write_mp4(KinoraWriter* writer, const KinoraPicture* picture, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->write(*picture);
    return KINORA_OK;
  });
}

KinoraStatus finish_mp4(KinoraWriter* writer, KinoraMessage* message) {
  const std::unique_ptr<Mp4Writer> owned(self(writer));
  return guarded(message, [&] {
    owned->finish();
    return KINORA_OK;
  });
}

void abandon_mp4(KinoraWriter* writer) { delete self(writer); }

constexpr KinoraFormat module_format() {
  KinoraFormat format = mp4_description();
  format.open_writer = open_mp4;
  format.writer_write = write_mp4;
  format.writer_finish = finish_mp4;
  format.writer_abandon = abandon_mp4;
  return format;
}

constexpr KinoraFormat kFormat = module_format();

} // namespace
} // namespace kinora::formats

extern "C" const KinoraPlugin* kinora_plugin(std::uint32_t host_abi_version) {
  static const KinoraFormat* const formats[] = {&kinora::formats::kFormat};
  static const KinoraPlugin plugin = {sizeof(KinoraPlugin), KINORA_PLUGIN_ABI, "mp4", "", formats, 1};
  return host_abi_version == KINORA_PLUGIN_ABI ? &plugin : nullptr;
}
