#include "png/png_writer.h"

#include <algorithm>
#include <cmath>

#include "common/files.h"
#include "common/pictures.h"
#include "core/image_codec.h"

namespace kinora::formats {
namespace {

/// Axes x right, y up, z towards the camera, as in tools for artists; −1 to 1 as 0 to 255. No normal is black.
ColorImage as_colors(const Image<float>& normals) {
  ColorImage colors(normals.width(), normals.height(), 3);
  for (std::size_t i = 0; i < normals.pixel_count(); ++i) {
    const float* n = normals.data() + 3 * i;
    if (n[0] == 0 && n[1] == 0 && n[2] == 0) continue;
    const float axes[] = {n[0], -n[1], -n[2]};
    for (std::size_t c = 0; c < 3; ++c) {
      colors.data()[3 * i + c] =
          static_cast<std::uint8_t>(std::lround(127.5F * (1 + std::clamp(axes[c], -1.0F, 1.0F))));
    }
  }
  return colors;
}

} // namespace

Facts PngWriter::texts(const char* content) const {
  if (facts_.empty()) return {};
  Facts texts = {{"Software", "Kinora"}, {"content", content}};
  texts.insert(texts.end(), facts_.begin(), facts_.end());
  return texts;
}

void PngWriter::write(const KinoraPicture& picture) {
  const std::filesystem::path path = files_.next(picture.name);
  write_file(path, encode_png(color_of(picture.color), texts("sRGB, straight alpha")));
  if (picture.depth.data != nullptr)
    write_file(path_beside(path, ".depth.png"),
               encode_png16(depth_of(picture.depth), texts("millimetres along the optical axis, 0: nothing")));
  if (picture.normal.data != nullptr)
    write_file(path_beside(path, ".normal.png"),
               encode_png(as_colors(normal_of(picture.normal)),
                          texts("x right, y up, z to the camera; -1 to 1 as 0 to 255, black: nothing")));
  if (picture.confidence.data != nullptr)
    write_file(path_beside(path, ".confidence.png"),
               encode_png(confidence_of(picture.confidence), texts("how well this side was seen, 0: never")));
}

} // namespace kinora::formats
