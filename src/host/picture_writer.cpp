#include "host/picture_writer.h"

#include <fmt/format.h>

#include "host/interface_struct.h"
#include "host/option_values.h"
#include "host/plugin_table.h"

namespace kinora::host {
namespace {

template <class T> KinoraImage view_of(const Image<T>& image, KinoraPixelType type) {
  KinoraImage view{};
  if (image.empty()) return view;
  view.width = image.width();
  view.height = image.height();
  view.channels = image.channels();
  view.pixel_type = type;
  view.row_bytes = sizeof(T) * static_cast<std::size_t>(image.width()) * static_cast<std::size_t>(image.channels());
  view.data = image.data();
  return view;
}

ColorImage on_black(const ColorImage& rgba) {
  ColorImage rgb(rgba.width(), rgba.height(), 3);
  for (std::size_t i = 0; i < rgba.pixel_count(); ++i) {
    const std::uint8_t* from = rgba.data() + 4 * i;
    for (std::size_t c = 0; c < 3; ++c)
      rgb.data()[3 * i + c] = static_cast<std::uint8_t>((from[c] * from[3] + 127) / 255);
  }
  return rgb;
}

std::unique_ptr<KinoraWriter, void (*)(KinoraWriter*)>
open_writer(const KinoraFormat& format, const std::filesystem::path& path, const Options& options) {
  if (!supports(format, KINORA_WRITES_PICTURES))
    throw Error(ErrorCode::kUsage, fmt::format("the format {} cannot be written, only read", format.name));
  check_options(format, options);
  const std::vector<KinoraOptionValue> values = option_values(options);
  auto message = make_struct<KinoraMessage>();
  KinoraWriter* writer = nullptr;
  const KinoraStatus status = format.open_writer(path.c_str(), values.data(), values.size(), &writer, &message);
  if (status != KINORA_OK) throw error_of(status, message, path.string());
  return {writer, format.writer_abandon};
}

} // namespace

PictureWriter::PictureWriter(const KinoraFormat& format, const std::filesystem::path& path, const Options& options)
    : format_(&format), writer_(open_writer(format, path, options)) {}

void PictureWriter::write(const Picture& picture) {
  const bool flatten = picture.color.channels() == 4 && !supports(*format_, KINORA_WRITES_ALPHA);
  const ColorImage flat = flatten ? on_black(picture.color) : ColorImage();
  auto given = make_struct<KinoraPicture>();
  given.name = picture.name.c_str();
  given.time = picture.time;
  given.color = view_of(flatten ? flat : picture.color, KINORA_PIXEL_U8);
  if (supports(*format_, KINORA_WRITES_DEPTH)) given.depth = view_of(picture.depth, KINORA_PIXEL_U16);
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status = format_->writer_write(writer_.get(), &given, &message);
  if (status != KINORA_OK) throw error_of(status, message, format_->name);
}

void PictureWriter::finish() {
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status = format_->writer_finish(writer_.release(), &message);
  if (status != KINORA_OK) throw error_of(status, message, format_->name);
}

} // namespace kinora::host
