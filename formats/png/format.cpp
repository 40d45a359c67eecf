#include "png/format.h"

#include "common/boundary.h"
#include "png/png_writer.h"

namespace kinora::formats {
namespace {

PngWriter* self(KinoraWriter* writer) { return reinterpret_cast<PngWriter*>(writer); }

KinoraStatus open_png(const char* path, const KinoraOptionValue* options, size_t option_count, KinoraWriter** writer,
                      KinoraMessage* message) {
  return guarded(message, [&] {
    const auto given = option_map(options, option_count);
    const auto layout = given.find("layout");
    const auto chosen = PictureFiles::layout_of(layout == given.end() ? "auto" : layout->second, path, ".png");
    *writer = reinterpret_cast<KinoraWriter*>(new PngWriter({path, chosen, ".png"}));
    return KINORA_OK;
  });
}

KinoraStatus write_png(KinoraWriter* writer, const KinoraPicture* picture, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->write(*picture);
    return KINORA_OK;
  });
}

KinoraStatus finish_png(KinoraWriter* writer, KinoraMessage* message) {
  const std::unique_ptr<PngWriter> owned(self(writer));
  return guarded(message, [&] {
    owned->finish();
    return KINORA_OK;
  });
}

void abandon_png(KinoraWriter* writer) { delete self(writer); }

const KinoraOption kOptions[] = {{"layout", "auto|folder|file", "auto",
                                  "A folder of pictures or a single one; auto: a file if the path ends in .png.",
                                  nullptr}};

constexpr KinoraFormat png_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "png";
  format.description =
      "PNG pictures with alpha, one file or a folder; depth in 16-bit millimetres, normals, confidence";
  format.extensions = ".png";
  format.capabilities = KINORA_WRITES_PICTURES | KINORA_WRITES_ALPHA | KINORA_WRITES_DEPTH | KINORA_WRITES_NORMALS |
                        KINORA_WRITES_CONFIDENCE;
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  format.open_writer = open_png;
  format.writer_write = write_png;
  format.writer_finish = finish_png;
  format.writer_abandon = abandon_png;
  return format;
}

} // namespace

constinit const KinoraFormat kPngFormat = png_format();

} // namespace kinora::formats
