// PNG and JPEG between memory and images. No files: whoever has the bytes names them in `source`, for errors.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/image.h"

namespace kinora {

using Bytes = std::vector<std::byte>;

/// 8-bit PNG or JPEG to 3 channels sRGB (grey is repeated, alpha dropped, palettes expanded). JPEG's EXIF is ignored.
/// Throws Error(kCorruptInput), naming `source`, if the bytes are empty, truncated, damaged, larger than
/// 16384 pixels on a side, more than 64 MiB in memory of a file that is far smaller than photographs are, or of another
/// kind. A truncated picture is an error, never half a picture. Thread-safe.
ColorImage decode_color(std::span<const std::byte> bytes, const std::string& source);

/// Single-channel 16-bit PNG. Throws as above; an 8-bit or colour PNG or a JPEG is an error that says so.
DepthImage16 decode_depth16(std::span<const std::byte> bytes, const std::string& source);

/// Single-channel PNG of 1, 8 or 16 bits (or a palette: its indices) as labels. 8-bit values are the labels, unless
/// the picture holds only 0 and one other value v > 64 (a binary mask: label 1). 1 and 16 bit: non-zero is label 1.
LabelImage decode_labels(std::span<const std::byte> bytes, const std::string& source);

/// Keywords (1 to 79 letters of ASCII) and texts (UTF-8) that a PNG says beside its picture, as iTXt chunks.
using PngTexts = std::vector<std::pair<std::string, std::string>>;

/// 8-bit PNG of 1, 3 or 4 channels. The same image and texts give the same bytes (no date inside).
Bytes encode_png(const ColorImage& image, const PngTexts& texts = {});
/// Single-channel 16-bit PNG.
Bytes encode_png16(const DepthImage16& image, const PngTexts& texts = {});

} // namespace kinora
