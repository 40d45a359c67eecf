#include "ros/ros_images.h"

#include <algorithm>
#include <array>
#include <bit>

#include "common/byte_reader.h"
#include "common/float_depth.h"
#include "core/image_codec.h"
#include "ros/rvl.h"

namespace kinora::formats {
namespace {

constexpr std::uint32_t kMaxSide = 16384;

[[noreturn]] void fail(const std::string& source, const std::string& problem) {
  throw Error(ErrorCode::kCorruptInput, source + ": " + problem);
}

/// Where red, green and blue are in a pixel.
struct ColorLayout {
  const char* encoding;
  std::size_t bytes;
  std::array<std::size_t, 3> rgb;
};
constexpr ColorLayout kColorLayouts[] = {{"rgb8", 3, {0, 1, 2}},  {"bgr8", 3, {2, 1, 0}}, {"rgba8", 4, {0, 1, 2}},
                                         {"bgra8", 4, {2, 1, 0}}, {"8UC3", 3, {2, 1, 0}}, {"mono8", 1, {0, 0, 0}}};

const ColorLayout* layout_of(const std::string& encoding) {
  for (const ColorLayout& layout : kColorLayouts)
    if (encoding == layout.encoding) return &layout;
  return nullptr;
}

bool is_unit_depth(const std::string& encoding) {
  return encoding == "16UC1" || encoding == "mono16" || encoding == "Z16";
}

void check_size(const ImageMessage& message, std::size_t pixel_bytes, const std::string& source) {
  if (message.width < 1 || message.height < 1 || message.width > kMaxSide || message.height > kMaxSide)
    fail(source,
         "a picture of " + std::to_string(message.width) + "x" + std::to_string(message.height) + " pixels is absurd");
  const std::size_t step = message.step;
  if (step < pixel_bytes * message.width || step * message.height > message.data.size())
    fail(source, "the picture has fewer bytes than its size needs");
}

template <class Value> Value value_at(const ImageMessage& message, std::uint32_t u, std::uint32_t v) {
  std::array<std::byte, sizeof(Value)> bytes;
  const std::size_t at = std::size_t{message.step} * v + sizeof(Value) * u;
  std::copy_n(message.data.begin() + static_cast<std::ptrdiff_t>(at), sizeof(Value), bytes.begin());
  if (message.big_endian) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<Value>(bytes);
}

/// image_transport's compressedDepth: 12 bytes, of which two floats say how metres became numbers, and a PNG or RVL.
DepthImage16 compressed_depth(const ImageMessage& message, const std::string& source) {
  const bool wrapped = message.encoding.find("compressedDepth") != std::string::npos;
  ByteReader reader(message.data, source);
  float a = 0;
  float b = 0;
  if (wrapped) {
    (void)reader.number<std::uint32_t>();
    a = reader.number<float>();
    b = reader.number<float>();
  }
  const auto packed = reader.bytes(reader.left());
  const bool rvl = message.encoding.find("rvl") != std::string::npos;
  DepthImage16 depth = rvl ? unpack_rvl(packed, source) : decode_depth16(packed, source);
  if (!is_float_depth(message.encoding)) return depth;
  for (std::uint16_t& value : depth.values())
    value = value == 0 ? std::uint16_t{0} : depth_units(a / (value - double{b}));
  return depth;
}

} // namespace

bool is_float_depth(const std::string& encoding) { return encoding.starts_with("32FC1"); }

bool is_depth_encoding(const std::string& encoding, bool compressed) {
  if (compressed)
    return encoding.find("compressedDepth") != std::string::npos || encoding.starts_with("16UC1") ||
           encoding.starts_with("mono16");
  return is_unit_depth(encoding) || is_float_depth(encoding);
}

bool is_color_encoding(const std::string& encoding, bool compressed) {
  if (compressed) return !is_depth_encoding(encoding, true);
  return layout_of(encoding) != nullptr;
}

ColorImage color_image_of(const ImageMessage& message, bool compressed, const std::string& source) {
  if (compressed) return decode_color(message.data, source);
  const ColorLayout* layout = layout_of(message.encoding);
  if (layout == nullptr) fail(source, "a picture is encoded in an unknown way (" + message.encoding + ")");
  check_size(message, layout->bytes, source);
  ColorImage image(static_cast<int>(message.width), static_cast<int>(message.height), 3);
  const auto* data = reinterpret_cast<const std::uint8_t*>(message.data.data());
  std::uint8_t* to = image.data();
  for (std::uint32_t v = 0; v < message.height; ++v) {
    const std::uint8_t* from = data + std::size_t{message.step} * v;
    for (std::uint32_t u = 0; u < message.width; ++u, from += layout->bytes)
      for (const std::size_t channel : layout->rgb) *to++ = from[channel];
  }
  return image;
}

DepthImage16 depth_image_of(const ImageMessage& message, bool compressed, const std::string& source) {
  if (compressed) return compressed_depth(message, source);
  const bool floats = is_float_depth(message.encoding);
  if (!floats && !is_unit_depth(message.encoding))
    fail(source, "depth is encoded in an unknown way (" + message.encoding + ")");
  check_size(message, floats ? sizeof(float) : sizeof(std::uint16_t), source);
  DepthImage16 image(static_cast<int>(message.width), static_cast<int>(message.height));
  std::uint16_t* to = image.data();
  for (std::uint32_t v = 0; v < message.height; ++v)
    for (std::uint32_t u = 0; u < message.width; ++u)
      *to++ = floats ? depth_units(value_at<float>(message, u, v)) : value_at<std::uint16_t>(message, u, v);
  return image;
}

} // namespace kinora::formats
