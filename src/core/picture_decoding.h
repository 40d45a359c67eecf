// What the PNG and the JPEG decoder share: inside of image_codec.h, not for others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace kinora {

constexpr std::size_t kMaxPictureSide = 16384;

/// What a picture whose file has `file_bytes` may take in memory: 64 MiB, and more only where the file is large as
/// well. Photographs unpack to some ten times their files' size.
constexpr std::size_t max_picture_bytes(std::size_t file_bytes) { return (std::size_t{64} << 20U) + 256 * file_bytes; }

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

  /// Makes room for `height` rows. False with a problem if that is more than the file explains.
  bool allocate(std::size_t row_bytes) {
    const auto count = static_cast<std::size_t>(height);
    if (row_bytes * count > max_picture_bytes(bytes.size())) {
      problem = "the file is far too short for a picture of " + std::to_string(width) + "x" + std::to_string(height) +
                " pixels";
      return false;
    }
    pixels.resize(row_bytes * count);
    rows.resize(count);
    for (std::size_t v = 0; v < count; ++v) rows[v] = pixels.data() + v * row_bytes;
    return true;
  }
};

} // namespace kinora
