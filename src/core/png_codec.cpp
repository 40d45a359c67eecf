#include "core/png_codec.h"

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <iterator>

#include <png.h>

#include "core/error.h"

namespace kinora {
namespace {

/// Deflate cannot shrink below 1/1032; a header that promises more than its bytes can hold is damaged or hostile.
constexpr std::size_t kMaxDeflateRatio = 1032;
constexpr int kPngCompressionLevel = 2; ///< low: writing a picture must not cost more than drawing it

[[noreturn]] void fail(const std::string& source, const std::string& problem) {
  throw Error(ErrorCode::kCorruptInput, source + ": " + problem);
}

void on_png_read(png_structp png, png_bytep target, std::size_t size) {
  auto& decode = *static_cast<PictureDecoding*>(png_get_io_ptr(png));
  if (size > decode.bytes.size() - decode.position) png_error(png, "the file is cut short");
  std::memcpy(target, decode.bytes.data() + decode.position, size);
  decode.position += size;
}

void on_png_error(png_structp png, png_const_charp message) {
  static_cast<PictureDecoding*>(png_get_error_ptr(png))->problem = message;
  png_longjmp(png, 1);
}

void on_png_warning(png_structp /*png*/, png_const_charp /*message*/) {}

/// Checks the header against the target and sets the conversions. False with a problem if it is of another kind.
bool accept_png_header(PictureDecoding& decode, png_structp png, png_infop info, PngTarget target) {
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
bool read_png(PictureDecoding& decode, PngTarget target, png_structp png, png_infop info) {
  if (setjmp(png_jmpbuf(png)) != 0) return false; // NOLINT(cert-err52-cpp): libpng's way of reporting errors
  png_set_read_fn(png, &decode, on_png_read);
  png_set_user_limits(png, kMaxPictureSide, kMaxPictureSide);
  png_read_info(png, info);
  if (!accept_png_header(decode, png, info, target)) return false;
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  decode.channels = png_get_channels(png, info);
  if (!decode.allocate(png_get_rowbytes(png, info))) return false;
  for (int pass = 0; pass < passes; ++pass) png_read_rows(png, decode.rows.data(), nullptr, decode.rows.size());
  png_read_end(png, nullptr);
  return true;
}

struct PngHeader {
  png_uint_32 width;
  png_uint_32 height;
  int bits;
  int type;
};

struct Encode {
  Bytes bytes;
  std::vector<const std::uint8_t*> rows;
  std::vector<png_text> texts; ///< their strings are another's
};

/// libpng wants names that it could change.
png_text chunk_of(const std::pair<std::string, std::string>& text) {
  png_text chunk{};
  chunk.compression = PNG_ITXT_COMPRESSION_NONE;
  chunk.key = const_cast<char*>(text.first.c_str());
  chunk.text = const_cast<char*>(text.second.c_str());
  chunk.itxt_length = text.second.size();
  return chunk;
}

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

/// libpng's own would print.
void on_png_write_error(png_structp png, png_const_charp /*message*/) { png_longjmp(png, 1); }

bool write_png(Encode& encode, png_structp png, png_infop info, const PngHeader& header) {
  if (setjmp(png_jmpbuf(png)) != 0) return false; // NOLINT(cert-err52-cpp)
  png_set_write_fn(png, &encode, on_png_write, on_png_flush);
  png_set_compression_level(png, kPngCompressionLevel);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  png_set_IHDR(png, info, header.width, header.height, header.bits, header.type, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_text(png, info, encode.texts.data(), static_cast<int>(encode.texts.size()));
  png_write_info(png, info);
  if (header.bits == 16) png_set_swap(png);
  for (const std::uint8_t* row : encode.rows) png_write_row(png, row);
  png_write_end(png, info);
  return true;
}

} // namespace

bool is_png(std::span<const std::byte> bytes) {
  return bytes.size() >= 8 && png_sig_cmp(reinterpret_cast<png_const_bytep>(bytes.data()), 0, 8) == 0;
}

PictureDecoding decode_png(std::span<const std::byte> bytes, PngTarget target, const std::string& source) {
  PictureDecoding decode;
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

Bytes encode_png_rows(int width, int bits, int channels, std::vector<const std::uint8_t*> rows, const PngTexts& texts) {
  const int type = channels == 1 ? PNG_COLOR_TYPE_GRAY : channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGB_ALPHA;
  const PngHeader header{static_cast<png_uint_32>(width), static_cast<png_uint_32>(rows.size()), bits, type};
  Encode encode;
  encode.rows = std::move(rows);
  std::ranges::transform(texts, std::back_inserter(encode.texts), chunk_of);
  struct Handles {
    png_structp png;
    png_infop info;
    ~Handles() { png_destroy_write_struct(&png, &info); }
  };
  Handles handles{png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, on_png_write_error, on_png_warning), nullptr};
  if (handles.png == nullptr) throw std::bad_alloc();
  handles.info = png_create_info_struct(handles.png);
  if (handles.info == nullptr || !write_png(encode, handles.png, handles.info, header))
    throw Error(ErrorCode::kFailure, "a picture of " + std::to_string(header.width) + "x" +
                                         std::to_string(header.height) + " pixels cannot be written as PNG");
  return std::move(encode.bytes);
}

} // namespace kinora
