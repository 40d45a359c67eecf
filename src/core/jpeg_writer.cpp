#include "core/jpeg_writer.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include <jpeglib.h>

#include "core/error.h"

namespace kinora {
namespace {

// libjpeg's own handler ends the process; it must not return.
[[noreturn]] void throw_error(j_common_ptr jpeg) {
  std::array<char, JMSG_LENGTH_MAX> text{};
  jpeg->err->format_message(jpeg, text.data());
  throw Error(ErrorCode::kFailure, std::string("a picture cannot be packed as JPEG: ") + text.data());
}

} // namespace

std::vector<std::byte> encode_jpeg(const ColorImage& image, int quality) {
  constexpr int kFullColor = 90;
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  errors.error_exit = throw_error;
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long count = 0;
  const std::unique_ptr<jpeg_compress_struct, void (*)(jpeg_compress_struct*)> owned(
      &jpeg, [](jpeg_compress_struct* made) { jpeg_destroy_compress(made); });
  const std::unique_ptr<unsigned char*, void (*)(unsigned char**)> memory(
      &bytes, [](unsigned char** made) { std::free(*made); });
  jpeg_mem_dest(&jpeg, &bytes, &count);
  jpeg.image_width = static_cast<JDIMENSION>(image.width());
  jpeg.image_height = static_cast<JDIMENSION>(image.height());
  jpeg.input_components = 3;
  jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, quality, TRUE);
  jpeg.optimize_coding = TRUE;
  if (quality >= kFullColor) {
    jpeg.comp_info[0].h_samp_factor = 1;
    jpeg.comp_info[0].v_samp_factor = 1;
  }
  jpeg_start_compress(&jpeg, TRUE);
  std::vector<JSAMPLE> row(3 * static_cast<std::size_t>(image.width()));
  while (jpeg.next_scanline < jpeg.image_height) {
    std::copy_n(image.pixel(0, static_cast<int>(jpeg.next_scanline)), row.size(), row.begin());
    JSAMPROW pointer = row.data();
    jpeg_write_scanlines(&jpeg, &pointer, 1);
  }
  jpeg_finish_compress(&jpeg);
  const auto* first = reinterpret_cast<const std::byte*>(bytes);
  return {first, first + count};
}

} // namespace kinora
