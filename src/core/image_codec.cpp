#include "core/image_codec.h"

#include <cstring>

#include "core/error.h"
#include "core/jpeg_decoder.h"
#include "core/png_codec.h"

namespace kinora {
namespace {

[[noreturn]] void fail(const std::string& source, const std::string& problem) {
  throw Error(ErrorCode::kCorruptInput, source + ": " + problem);
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
  const PictureDecoding decode =
      is_png(bytes) ? decode_png(bytes, PngTarget::kColor, source) : decode_jpeg(bytes, source);
  ColorImage image(decode.width, decode.height, 3);
  std::copy(decode.pixels.begin(), decode.pixels.end(), image.data());
  return image;
}

DepthImage16 decode_depth16(std::span<const std::byte> bytes, const std::string& source) {
  if (bytes.empty()) fail(source, "the file is empty");
  if (!is_png(bytes)) fail(source, "a depth image must be a single-channel 16-bit PNG");
  const PictureDecoding decode = decode_png(bytes, PngTarget::kDepth16, source);
  DepthImage16 image(decode.width, decode.height);
  std::memcpy(image.data(), decode.pixels.data(), decode.pixels.size());
  return image;
}

LabelImage decode_labels(std::span<const std::byte> bytes, const std::string& source) {
  if (bytes.empty()) fail(source, "the file is empty");
  if (!is_png(bytes)) fail(source, "a mask must be a single-channel PNG of labels");
  const PictureDecoding decode = decode_png(bytes, PngTarget::kLabels, source);
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

Bytes encode_png(const ColorImage& image, const PngTexts& texts) {
  const int channels = image.channels();
  if (image.empty() || (channels != 1 && channels != 3 && channels != 4))
    throw Error(ErrorCode::kFailure, "a PNG needs 1, 3 or 4 channels and at least one pixel");
  return encode_png_rows(image.width(), 8, channels, rows_of(image), texts);
}

Bytes encode_png16(const DepthImage16& image, const PngTexts& texts) {
  if (image.empty() || image.channels() != 1)
    throw Error(ErrorCode::kFailure, "a 16-bit PNG needs one channel and at least one pixel");
  return encode_png_rows(image.width(), 16, 1, rows_of(image), texts);
}

} // namespace kinora
