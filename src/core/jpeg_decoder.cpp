#include "core/jpeg_decoder.h"

#include <csetjmp>
#include <cstdio>
#include <memory>

#include <jerror.h>
#include <jpeglib.h>

#include "core/error.h"

namespace kinora {
namespace {

/// A baseline or progressive block of 64 pixels costs at least one bit.
constexpr std::size_t kMaxJpegPixelsPerByte = 512;

[[noreturn]] void fail(const std::string& source, const std::string& problem) {
  throw Error(ErrorCode::kCorruptInput, source + ": " + problem);
}

struct JpegErrors {
  jpeg_error_mgr base; // first, so that libjpeg's pointer is ours
  std::jmp_buf jump;
  PictureDecoding* decode;
};

[[noreturn]] void on_jpeg_error(j_common_ptr jpeg) {
  auto* errors = reinterpret_cast<JpegErrors*>(jpeg->err);
  char text[JMSG_LENGTH_MAX];
  jpeg->err->format_message(jpeg, text);
  // Which libjpeg would need where its coefficients are more than max_memory_to_use.
  const bool too_large = jpeg->err->msg_code == JERR_NO_BACKING_STORE;
  errors->decode->problem = too_large ? "the file is far too short for so large a progressive picture" : text;
  std::longjmp(errors->jump, 1); // NOLINT(cert-err52-cpp): libjpeg's way of reporting errors
}

/// libjpeg only warns of a picture that ends early and fills the rest with grey: here that is an error.
void on_jpeg_message(j_common_ptr jpeg, int level) {
  if (level >= 0) return;
  switch (jpeg->err->msg_code) {
  case JWRN_EXTRANEOUS_DATA:
  case JWRN_ADOBE_XFORM:
  case JWRN_JFIF_MAJOR:
  case JWRN_TOO_MUCH_DATA:
    return; // harmless habits of some cameras
  default:
    on_jpeg_error(jpeg);
  }
}

bool read_jpeg(PictureDecoding& decode, JpegErrors& errors, jpeg_decompress_struct& jpeg) {
  if (setjmp(errors.jump) != 0) return false; // NOLINT(cert-err52-cpp)
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(decode.bytes.data()),
               static_cast<unsigned long>(decode.bytes.size()));
  jpeg_read_header(&jpeg, TRUE);
  const std::size_t pixels = std::size_t{jpeg.image_width} * jpeg.image_height;
  if (jpeg.image_width > kMaxPictureSide || jpeg.image_height > kMaxPictureSide ||
      pixels / kMaxJpegPixelsPerByte > decode.bytes.size()) {
    decode.problem = "the JPEG's size is larger than its bytes can hold or than 16384 pixels on a side";
    return false;
  }
  // Of a progressive picture libjpeg keeps all coefficients.
  jpeg.mem->max_memory_to_use = static_cast<long>(max_picture_bytes(decode.bytes.size()));
  jpeg.out_color_space = JCS_RGB;
  jpeg_start_decompress(&jpeg);
  decode.width = static_cast<int>(jpeg.output_width);
  decode.height = static_cast<int>(jpeg.output_height);
  decode.channels = 3;
  if (!decode.allocate(std::size_t{jpeg.output_width} * 3)) return false;
  while (jpeg.output_scanline < jpeg.output_height)
    jpeg_read_scanlines(&jpeg, decode.rows.data() + jpeg.output_scanline, jpeg.output_height - jpeg.output_scanline);
  jpeg_finish_decompress(&jpeg);
  return true;
}

} // namespace

bool is_jpeg(std::span<const std::byte> bytes) {
  return bytes.size() >= 3 && bytes[0] == std::byte{0xFF} && bytes[1] == std::byte{0xD8} && bytes[2] == std::byte{0xFF};
}

PictureDecoding decode_jpeg(std::span<const std::byte> bytes, const std::string& source) {
  PictureDecoding decode;
  decode.bytes = bytes;
  jpeg_decompress_struct jpeg{};
  JpegErrors errors{};
  jpeg.err = jpeg_std_error(&errors.base);
  errors.base.error_exit = on_jpeg_error;
  errors.base.emit_message = on_jpeg_message;
  errors.decode = &decode;
  const std::unique_ptr<jpeg_decompress_struct, void (*)(jpeg_decompress_struct*)> destroy(
      &jpeg, [](jpeg_decompress_struct* handle) { jpeg_destroy_decompress(handle); });
  if (!read_jpeg(decode, errors, jpeg)) fail(source, "the JPEG is damaged or cut short (" + decode.problem + ")");
  return decode;
}

} // namespace kinora
