#include "png/format.h"

#include "common/writers.h"
#include "png/png_writer.h"

namespace kinora::formats {
namespace {

std::unique_ptr<PngWriter> open_png(const char* path, const OptionMap& options) {
  const auto layout = PictureFiles::layout_of(option_text(options, "layout", "auto"), path, ".png");
  return std::make_unique<PngWriter>(PictureFiles(path, layout, ".png"));
}

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
  set_picture_writer<PngWriter, open_png>(format);
  return format;
}

} // namespace

constinit const KinoraFormat kPngFormat = png_format();

} // namespace kinora::formats
