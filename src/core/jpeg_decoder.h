// JPEG through libjpeg: inside of image_codec.h, not for others.
#pragma once

#include "core/picture_decoding.h"

namespace kinora {

bool is_jpeg(std::span<const std::byte> bytes);

/// 3 channels of 8 bits, sRGB. Throws Error(kCorruptInput), naming `source`.
PictureDecoding decode_jpeg(std::span<const std::byte> bytes, const std::string& source);

} // namespace kinora
