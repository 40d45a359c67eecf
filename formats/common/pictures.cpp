#include "common/pictures.h"

#include <cstring>

#include "core/error.h"

namespace kinora::formats {
namespace {

template <class T> Image<T> copy_of(const KinoraImage& image) {
  Image<T> copy(image.width, image.height, image.channels);
  const std::size_t row_bytes =
      sizeof(T) * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.channels);
  for (int v = 0; v < image.height; ++v)
    std::memcpy(copy.pixel(0, v), static_cast<const std::byte*>(image.data) + image.row_bytes * v, row_bytes);
  return copy;
}

bool has_pixels(const KinoraImage& image) { return image.data != nullptr && image.width > 0 && image.height > 0; }

} // namespace

ColorImage color_of(const KinoraImage& image) {
  if (!has_pixels(image) || image.pixel_type != KINORA_PIXEL_U8 || (image.channels != 3 && image.channels != 4))
    throw Error(ErrorCode::kUsage, "a picture must have 8 bits and 3 or 4 channels");
  return copy_of<std::uint8_t>(image);
}

DepthImage16 depth_of(const KinoraImage& image) {
  if (!has_pixels(image) || image.pixel_type != KINORA_PIXEL_U16 || image.channels != 1)
    throw Error(ErrorCode::kUsage, "a depth picture must have 16 bits and one channel");
  return copy_of<std::uint16_t>(image);
}

Image<float> normal_of(const KinoraImage& image) {
  if (!has_pixels(image) || image.pixel_type != KINORA_PIXEL_F32 || image.channels != 3)
    throw Error(ErrorCode::kUsage, "a picture of normals must have floats and three channels");
  return copy_of<float>(image);
}

Image<float> metric_depth_of(const KinoraImage& image) {
  if (!has_pixels(image) || image.pixel_type != KINORA_PIXEL_F32 || image.channels != 1)
    throw Error(ErrorCode::kUsage, "a picture of depth in metres must have floats and one channel");
  return copy_of<float>(image);
}

Image<std::uint8_t> confidence_of(const KinoraImage& image) {
  if (!has_pixels(image) || image.pixel_type != KINORA_PIXEL_U8 || image.channels != 1)
    throw Error(ErrorCode::kUsage, "a picture of confidence or labels must have 8 bits and one channel");
  return copy_of<std::uint8_t>(image);
}

LabelImage labels_of(const KinoraImage& image) { return confidence_of(image); }

} // namespace kinora::formats
