#include "core/image_codec.h"

#include <csetjmp>
#include <cstdio>

#include <jerror.h>
#include <jpeglib.h>
#include <png.h>

#include "core/error.h"

namespace kinora {
namespace {

constexpr std::size_t kMaxSide = 16384;
/// Deflate cannot shrink below 1/1032; a header that promises more than its bytes can hold is damaged or hostile.
constexpr std::size_t kMaxDeflateRatio = 1032;
/// A baseline or progressive block of 64 pixels costs at least one bit.
constexpr std::size_t kMaxJpegPixelsPerByte = 512;
constexpr int kPngCompressionLevel = 2; ///< low: writing a picture must not cost more than drawing it

enum class PngTarget { kColor, kDepth16, kLabels };

/// Everything that must survive a longjmp of libpng or libjpeg lives here, outside the frames that are jumped over.
struct Decode {
  std::span<const std::byte> bytes;
  std::size_t position = 0;
  std::string problem; ///< why it failed
  int width = 0;
  int height = 0;
  int bit_depth = 0;
  int channels = 0;
  std::vector<std::uint8_t> pixels; ///< row by row, without padding
  std::vector<std::uint8_t*> rows;
};

[[noreturn]] void fail(const std::string& source, const std::string& problem) {
  throw Error(ErrorCode::kCorruptInput, source + ": " + problem);
}

bool is_png(std::span<const std::byte> bytes) {
  return bytes.size() >= 8 && png_sig_cmp(reinterpret_cast<png_const_bytep>(bytes.data()), 0, 8) == 0;
}

bool is_jpeg(std::span<const std::byte> bytes) {
  return bytes.size() >= 3 && bytes[0] == std::byte{0xFF} && bytes[1] == std::byte{0xD8} && bytes[2] == std::byte{0xFF};
}

void set_layout(Decode& decode, std::size_t row_bytes) {
  const std::size_t height = static_cast<std::size_t>(decode.height);
  decode.pixels.resize(row_bytes * height);
  decode.rows.resize(height);
  for (std::size_t v = 0; v < height; ++v) decode.rows[v] = decode.pixels.data() + v * row_bytes;
}

// ---- PNG, reading

void on_png_read(png_structp png, png_bytep target, std::size_t size) {
  auto& decode = *static_cast<Decode*>(png_get_io_ptr(png));
  if (size > decode.bytes.size() - decode.position) png_error(png, "the file is cut short");
  std::memcpy(target, decode.bytes.data() + decode.position, size);
  decode.position += size;
}

void on_png_error(png_structp png, png_const_charp message) {
  static_cast<Decode*>(png_get_error_ptr(png))->problem = message;
  png_longjmp(png, 1);
}

void on_png_warning(png_structp /*png*/, png_const_charp /*message*/) {}

/// Checks the header against the target and sets the conversions. False with a problem if it is of another kind.
bool accept_png_header(Decode& decode, png_structp png, png_infop info, PngTarget target) {
  const int type = png_get_color_type(png, info);
  const int bits = png_get_bit_depth(png, info);
  decode.width = static_cast<int>(png_get_image_width(png, info));
  decode.height = static_cast<int>(png_get_image_height(png, info));
  decode.bit_depth = bits;
  const bool grey = type == PNG_COLOR_TYPE_GRAY;
  if (target == PngTarget::kDepth16 && !(grey && bits == 16)) {
    decode.problem = "a depth image must be a single-channel 16-bit PNG, but this one has " + std::to_string(bits) +
                     " bits" + (grey ? "" : " and colour or alpha channels");
    return false;
  }
  if (target == PngTarget::kLabels && !grey && type != PNG_COLOR_TYPE_PALETTE) {
    decode.problem = "a mask must be a single-channel PNG of labels, but this one has colour or alpha channels";
    return false;
  }
  if (target == PngTarget::kColor && bits == 16) {
    decode.problem = "a colour image must have 8 bits per channel, but this PNG has 16 (is it a depth image?)";
    return false;
  }
  if (png_get_rowbytes(png, info) * static_cast<std::size_t>(decode.height) / kMaxDeflateRatio > decode.bytes.size()) {
    decode.problem = "the file is far too short for a picture of " + std::to_string(decode.width) + "x" +
                     std::to_string(decode.height) + " pixels";
    return false;
  }
  if (target == PngTarget::kDepth16) png_set_swap(png);
  if (target == PngTarget::kLabels) png_set_packing(png);
  if (target == PngTarget::kColor) {
    png_set_expand(png);
    png_set_strip_alpha(png);
    png_set_gray_to_rgb(png);
  }
  return true;
}

/// The only frame that libpng jumps back into: it holds nothing with a destructor.
bool read_png(Decode& decode, PngTarget target, png_structp png, png_infop info) {
  if (setjmp(png_jmpbuf(png)) != 0) return false; // NOLINT(cert-err52-cpp): libpng's way of reporting errors
  png_set_read_fn(png, &decode, on_png_read);
  png_set_user_limits(png, kMaxSide, kMaxSide);
  png_read_info(png, info);
  if (!accept_png_header(decode, png, info, target)) return false;
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  decode.channels = png_get_channels(png, info);
  set_layout(decode, png_get_rowbytes(png, info));
  for (int pass = 0; pass < passes; ++pass) png_read_rows(png, decode.rows.data(), nullptr, decode.rows.size());
  png_read_end(png, nullptr);
  return true;
}

Decode decode_png(std::span<const std::byte> bytes, PngTarget target, const std::string& source) {
  Decode decode;
  decode.bytes = bytes;
  struct Handles {
    png_structp png;
    png_infop info;
    ~Handles() { png_destroy_read_struct(&png, &info, nullptr); }
  };
  Handles handles{png_create_read_struct(PNG_LIBPNG_VER_STRING, &decode, on_png_error, on_png_warning), nullptr};
  if (handles.png == nullptr) throw std::bad_alloc();
  handles.info = png_create_info_struct(handles.png);
  if (handles.info == nullptr || !read_png(decode, target, handles.png, handles.info))
    fail(source, decode.problem.empty() ? "the PNG cannot be read" : decode.problem);
  return decode;
}

// ---- JPEG, reading

struct JpegErrors {
  jpeg_error_mgr base; // first, so that libjpeg's pointer is ours
  std::jmp_buf jump;
  Decode* decode;
};

[[noreturn]] void on_jpeg_error(j_common_ptr jpeg) {
  auto* errors = reinterpret_cast<JpegErrors*>(jpeg->err);
  char text[JMSG_LENGTH_MAX];
  jpeg->err->format_message(jpeg, text);
  errors->decode->problem = text;
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

bool read_jpeg(Decode& decode, JpegErrors& errors, jpeg_decompress_struct& jpeg) {
  if (setjmp(errors.jump) != 0) return false; // NOLINT(cert-err52-cpp)
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(decode.bytes.data()),
               static_cast<unsigned long>(decode.bytes.size()));
  jpeg_read_header(&jpeg, TRUE);
  const std::size_t pixels = std::size_t{jpeg.image_width} * jpeg.image_height;
  if (jpeg.image_width > kMaxSide || jpeg.image_height > kMaxSide ||
      pixels / kMaxJpegPixelsPerByte > decode.bytes.size()) {
    decode.problem = "the JPEG's size is larger than its bytes can hold or than 16384 pixels on a side";
    return false;
  }
  jpeg.out_color_space = JCS_RGB;
  jpeg_start_decompress(&jpeg);
  decode.width = static_cast<int>(jpeg.output_width);
  decode.height = static_cast<int>(jpeg.output_height);
  decode.channels = 3;
  set_layout(decode, std::size_t{jpeg.output_width} * 3);
  while (jpeg.output_scanline < jpeg.output_height)
    jpeg_read_scanlines(&jpeg, decode.rows.data() + jpeg.output_scanline, jpeg.output_height - jpeg.output_scanline);
  jpeg_finish_decompress(&jpeg);
  return true;
}

Decode decode_jpeg(std::span<const std::byte> bytes, const std::string& source) {
  Decode decode;
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

// ---- PNG, writing

struct PngHeader {
  png_uint_32 width;
  png_uint_32 height;
  int bits;
  int type;
};

struct Encode {
  Bytes bytes;
  std::vector<const std::uint8_t*> rows;
};

void on_png_write(png_structp png, png_bytep data, std::size_t size) {
  auto& encode = *static_cast<Encode*>(png_get_io_ptr(png));
  const auto* begin = reinterpret_cast<const std::byte*>(data);
  bool out_of_memory = false;
  try { // no exception may cross libpng
    encode.bytes.insert(encode.bytes.end(), begin, begin + size);
  } catch (const std::bad_alloc&) {
    out_of_memory = true;
  }
  if (out_of_memory) png_error(png, "out of memory");
}

void on_png_flush(png_structp /*png*/) {}

bool write_png(Encode& encode, png_structp png, png_infop info, const PngHeader& header) {
  if (setjmp(png_jmpbuf(png)) != 0) return false; // NOLINT(cert-err52-cpp)
  png_set_write_fn(png, &encode, on_png_write, on_png_flush);
  png_set_compression_level(png, kPngCompressionLevel);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  png_set_IHDR(png, info, header.width, header.height, header.bits, header.type, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  if (header.bits == 16) png_set_swap(png);
  for (const std::uint8_t* row : encode.rows) png_write_row(png, row);
  png_write_end(png, info);
  return true;
}

Bytes encode_rows(const PngHeader& header, std::vector<const std::uint8_t*> rows) {
  Encode encode;
  encode.rows = std::move(rows);
  struct Handles {
    png_structp png;
    png_infop info;
    ~Handles() { png_destroy_write_struct(&png, &info); }
  };
  Handles handles{png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr), nullptr};
  if (handles.png == nullptr) throw std::bad_alloc();
  handles.info = png_create_info_struct(handles.png);
  if (handles.info == nullptr || !write_png(encode, handles.png, handles.info, header))
    throw Error(ErrorCode::kFailure, "a picture of " + std::to_string(header.width) + "x" +
                                         std::to_string(header.height) + " pixels cannot be written as PNG");
  return std::move(encode.bytes);
}

template <class T> std::vector<const std::uint8_t*> rows_of(const Image<T>& image) {
  std::vector<const std::uint8_t*> rows;
  rows.reserve(static_cast<std::size_t>(image.height()));
  for (int v = 0; v < image.height(); ++v) rows.push_back(reinterpret_cast<const std::uint8_t*>(image.pixel(0, v)));
  return rows;
}

/// A mask of 0 and one large value is a binary mask: label 1.
void make_binary_mask_label_one(LabelImage& labels) {
  constexpr std::uint8_t kLargestLabel = 64;
  std::uint8_t other = 0;
  for (const std::uint8_t value : labels.values()) {
    if (value == 0 || value == other) continue;
    if (other != 0) return;
    other = value;
  }
  if (other <= kLargestLabel) return;
  for (std::uint8_t& value : labels.values()) value = value != 0 ? 1 : 0;
}

} // namespace

ColorImage decode_color(std::span<const std::byte> bytes, const std::string& source) {
  if (bytes.empty()) fail(source, "the file is empty");
  if (!is_png(bytes) && !is_jpeg(bytes)) fail(source, "a colour image must be a PNG or a JPEG");
  const Decode decode = is_png(bytes) ? decode_png(bytes, PngTarget::kColor, source) : decode_jpeg(bytes, source);
  ColorImage image(decode.width, decode.height, 3);
  std::copy(decode.pixels.begin(), decode.pixels.end(), image.data());
  return image;
}

DepthImage16 decode_depth16(std::span<const std::byte> bytes, const std::string& source) {
  if (bytes.empty()) fail(source, "the file is empty");
  if (!is_png(bytes)) fail(source, "a depth image must be a single-channel 16-bit PNG");
  const Decode decode = decode_png(bytes, PngTarget::kDepth16, source);
  DepthImage16 image(decode.width, decode.height);
  std::memcpy(image.data(), decode.pixels.data(), decode.pixels.size());
  return image;
}

LabelImage decode_labels(std::span<const std::byte> bytes, const std::string& source) {
  if (bytes.empty()) fail(source, "the file is empty");
  if (!is_png(bytes)) fail(source, "a mask must be a single-channel PNG of labels");
  const Decode decode = decode_png(bytes, PngTarget::kLabels, source);
  LabelImage image(decode.width, decode.height);
  const std::size_t count = image.pixel_count();
  if (decode.bit_depth == 16) {
    for (std::size_t i = 0; i < count; ++i)
      image.data()[i] = (decode.pixels[2 * i] | decode.pixels[2 * i + 1]) != 0 ? 1 : 0;
  } else {
    std::copy(decode.pixels.begin(), decode.pixels.end(), image.data());
    make_binary_mask_label_one(image);
  }
  return image;
}

Bytes encode_png(const ColorImage& image) {
  const int channels = image.channels();
  if (image.empty() || (channels != 1 && channels != 3 && channels != 4))
    throw Error(ErrorCode::kFailure, "a PNG needs 1, 3 or 4 channels and at least one pixel");
  const int type = channels == 1 ? PNG_COLOR_TYPE_GRAY : channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGB_ALPHA;
  return encode_rows({static_cast<png_uint_32>(image.width()), static_cast<png_uint_32>(image.height()), 8, type},
                     rows_of(image));
}

Bytes encode_png16(const DepthImage16& image) {
  if (image.empty() || image.channels() != 1)
    throw Error(ErrorCode::kFailure, "a 16-bit PNG needs one channel and at least one pixel");
  return encode_rows(
      {static_cast<png_uint_32>(image.width()), static_cast<png_uint_32>(image.height()), 16, PNG_COLOR_TYPE_GRAY},
      rows_of(image));
}

} // namespace kinora
