// Depth packed with RVL. Source: Wilson, "Fast Lossless Depth Image Compression", ISS 2017.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "core/image.h"

namespace kinora::formats {

/// Runs of zeros and of differences in groups of three bits, after width and height (32 bits each): what
/// compressed_depth_image_transport sends. Throws Error(kCorruptInput), naming `source`, if the size is absurd or the
/// bytes end too early.
DepthImage16 unpack_rvl(std::span<const std::byte> bytes, const std::string& source);

} // namespace kinora::formats
