// PNG through libpng: inside of image_codec.h, not for others.
#pragma once

#include "core/image_codec.h"
#include "core/picture_decoding.h"

namespace kinora {

enum class PngTarget { kColor, kDepth16, kLabels };

bool is_png(std::span<const std::byte> bytes);

/// Colour: 3 channels of 8 bits. Depth: one channel of 16 bits in machine order. Labels: as in the file, one or two
/// bytes per pixel. Throws Error(kCorruptInput), naming `source`, for damage or a picture of another kind.
PictureDecoding decode_png(std::span<const std::byte> bytes, PngTarget target, const std::string& source);

/// Bits of 8 with 1, 3 or 4 channels, or 16 with one; one pointer per row. Throws Error(kFailure).
Bytes encode_png_rows(int width, int bits, int channels, std::vector<const std::uint8_t*> rows, const PngTexts& texts);

} // namespace kinora
