#include "mp4/format.h"

#include "common/boundary.h"
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

const KinoraOption kOptions[] = {
    {"fps", "number", "30", "Nominal frames per second; the pictures' own times decide when each is shown.", nullptr},
    {"crf", "int", "18", "Quality from 0 (largest file) to 51 (smallest).", nullptr},
};

constexpr KinoraFormat mp4_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "mp4";
  format.description = "MP4 film: H.264, or MPEG-4 part 2 where no H.264 encoder is installed";
  format.extensions = ".mp4";
  format.capabilities = KINORA_WRITES_PICTURES | KINORA_WRITES_FILM;
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  format.open_writer = open_mp4;
  format.writer_write = write_mp4;
  format.writer_finish = finish_mp4;
  format.writer_abandon = abandon_mp4;
  return format;
}

} // namespace

constinit const KinoraFormat kMp4Format = mp4_format();

} // namespace kinora::formats
