// What the PNG and the JPEG decoder share: inside of image_codec.h, not for others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace kinora {

constexpr std::size_t kMaxPictureSide = 16384;

/// A picture on its way out of its file. Everything that must survive a longjmp of libpng or libjpeg lives here,
/// outside the frames that are jumped over.
struct PictureDecoding {
  std::span<const std::byte> bytes;
  std::size_t position = 0;
  std::string problem; ///< why it failed
  int width = 0;
  int height = 0;
  int bit_depth = 0;
  int channels = 0;
  std::vector<std::uint8_t> pixels; ///< row by row, without padding
  std::vector<std::uint8_t*> rows;

  /// Makes room for `height` rows.
  void allocate(std::size_t row_bytes) {
    const auto count = static_cast<std::size_t>(height);
    pixels.resize(row_bytes * count);
    rows.resize(count);
    for (std::size_t v = 0; v < count; ++v) rows[v] = pixels.data() + v * row_bytes;
  }
};

} // namespace kinora
