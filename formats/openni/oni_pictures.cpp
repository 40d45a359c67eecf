#include "openni/oni_pictures.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/byte_reader.h"
#include "core/image_codec.h"

namespace kinora::formats {
namespace {

constexpr int kMaxSide = 16384;
constexpr std::int64_t kMaxPixels = std::int64_t{1} << 24; // a byte may stand for 60 of them

/// The values of a packed picture, each given to `emit`. A byte holds two differences of -6 to 6 (or 7), or one and a
/// sign that a longer one follows, or says how many pairs of pixels are as the last one.
template <class Emit> void unpack_differences(ByteReader& in, const Emit& emit) {
  constexpr int kRepeats = 0xE0, kLong = 0xFF, kLongAfterThis = 15, kNone = 13;
  auto last = in.number<std::uint16_t>();
  emit(last);
  const auto less = [&](int difference) { emit(last = static_cast<std::uint16_t>(last - difference)); };
  const auto long_one = [&] {
    const int first = in.number<std::uint8_t>();
    if ((first & 0x80) != 0) return less(first - 192);
    emit(last = static_cast<std::uint16_t>(first << 8 | in.number<std::uint8_t>()));
  };
  while (in.left() > 0) {
    const int byte = in.number<std::uint8_t>();
    if (byte == kLong) {
      long_one();
    } else if (byte >= kRepeats) {
      for (int i = 0; i < 2 * (byte - kRepeats); ++i) emit(last);
    } else {
      less((byte >> 4) - 6);
      const int second = byte & 15;
      if (second == kLongAfterThis)
        long_one();
      else if (second != kNone)
        less(second - 6);
    }
  }
}

void unpack_depth(ByteReader& in, bool has_table, DepthImage16& depth) {
  std::vector<std::uint16_t> table(has_table ? in.number<std::uint16_t>() : 0);
  for (std::uint16_t& value : table) value = in.number<std::uint16_t>();
  std::uint16_t* to = depth.data();
  std::uint16_t* const end = to + depth.pixel_count();
  unpack_differences(in, [&](std::uint16_t value) {
    if (to == end || (has_table && value >= table.size())) in.fail("the packed depth is damaged");
    *to++ = has_table ? table[value] : value;
  });
  if (to != end) in.fail("the packed depth ends too early");
}

std::uint8_t to_byte(double value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0))); }

/// ITU-R BT.601, full range of the chroma, as PrimeSense's cameras mean it.
void store_yuv(int y, int u, int v, std::uint8_t* rgb) {
  const double luma = 1.164 * (y - 16);
  rgb[0] = to_byte(luma + 1.596 * (v - 128));
  rgb[1] = to_byte(luma - 0.813 * (v - 128) - 0.391 * (u - 128));
  rgb[2] = to_byte(luma + 2.018 * (u - 128));
}

/// Two pixels of four bytes share u and v.
ColorImage color_of_yuv(std::span<const std::byte> bytes, OniSize size, bool chroma_first) {
  ColorImage image(size.width, size.height, 3);
  const auto* from = reinterpret_cast<const std::uint8_t*>(bytes.data());
  const int luma = chroma_first ? 1 : 0;
  std::uint8_t* to = image.data();
  for (std::size_t i = 0; i < image.pixel_count() / 2; ++i, from += 4) {
    for (const int pixel : {0, 2}) {
      store_yuv(from[luma + pixel], from[1 - luma], from[3 - luma], to);
      to += 3;
    }
  }
  return image;
}

std::size_t bytes_per_pixel(OniPixels pixels) {
  switch (pixels) {
  case OniPixels::kGrey:
    return 1;
  case OniPixels::kUyvy:
  case OniPixels::kYuyv:
    return 2;
  case OniPixels::kRgb:
    return 3;
  default:
    return 0;
  }
}

[[noreturn]] void fail(const std::string& source, const std::string& problem) {
  throw Error(ErrorCode::kCorruptInput, source + ": " + problem);
}

} // namespace

OniSize size_of(const OniStream& stream, const std::string& source) {
  const OniSize size =
      stream.cropped ? OniSize{stream.crop_width, stream.crop_height} : OniSize{stream.width, stream.height};
  const bool sound = size.width > 0 && size.height > 0 && size.width <= kMaxSide && size.height <= kMaxSide &&
                     std::int64_t{size.width} * size.height <= kMaxPixels;
  if (!sound)
    fail(source, "pictures of " + std::to_string(size.width) + "x" + std::to_string(size.height) + " are absurd");
  return size;
}

DepthImage16 oni_depth(std::span<const std::byte> bytes, const OniStream& stream, const std::string& source) {
  const OniSize size = size_of(stream, source);
  ByteReader in(bytes, source);
  DepthImage16 depth(size.width, size.height);
  if (stream.codec == "NONE") {
    if (bytes.size() != depth.values().size_bytes()) fail(source, "it has not the bytes that its size needs");
    std::memcpy(depth.data(), bytes.data(), bytes.size());
  } else if (stream.codec == "16zP" || stream.codec == "16zT") {
    unpack_depth(in, stream.codec == "16zT", depth);
  } else {
    fail(source, "depth is packed in an unknown way (" + stream.codec + ")");
  }
  return depth;
}

bool is_jpeg_stream(const OniStream& stream) {
  return stream.codec == "JPEG" || (stream.codec == "NONE" && stream.pixels == OniPixels::kJpeg);
}

ColorImage oni_color(std::span<const std::byte> bytes, const OniStream& stream, const std::string& source) {
  const OniSize size = size_of(stream, source);
  if (is_jpeg_stream(stream)) {
    ColorImage image = decode_color(bytes, source);
    if (image.width() != size.width || image.height() != size.height) fail(source, "the JPEG is of another size");
    return image;
  }
  const std::size_t pixel_bytes = bytes_per_pixel(stream.pixels);
  if (stream.codec != "NONE" || pixel_bytes == 0) fail(source, "colour is stored in an unknown way");
  ColorImage image(size.width, size.height, 3);
  if (bytes.size() != pixel_bytes * image.pixel_count() || (pixel_bytes == 2 && size.width % 2 != 0))
    fail(source, "it has not the bytes that its size needs");
  if (pixel_bytes == 2) return color_of_yuv(bytes, size, stream.pixels == OniPixels::kUyvy);
  const auto* from = reinterpret_cast<const std::uint8_t*>(bytes.data());
  std::uint8_t* to = image.data();
  if (pixel_bytes == 3) {
    std::copy_n(from, bytes.size(), to);
  } else {
    for (std::size_t i = 0; i < bytes.size(); ++i, to += 3) std::fill_n(to, 3, from[i]);
  }
  return image;
}

} // namespace kinora::formats
