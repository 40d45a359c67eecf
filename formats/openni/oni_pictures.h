// Pictures of an OpenNI recording from their bytes.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "core/image.h"
#include "openni/oni_log.h"

namespace kinora::formats {

/// Size of the stream's pictures. Throws Error(kCorruptInput), naming `source`, if it is absurd.
struct OniSize {
  int width = 0;
  int height = 0;
};
OniSize size_of(const OniStream& stream, const std::string& source);

/// Depth as it is, or packed as differences of neighbours ("16zP"), also of numbers in a table ("16zT"). Throws
/// Error(kCorruptInput), naming `source`, if the bytes are not those of a picture of the stream's size.
DepthImage16 oni_depth(std::span<const std::byte> bytes, const OniStream& stream, const std::string& source);

/// Three channels. Throws as above.
ColorImage oni_color(std::span<const std::byte> bytes, const OniStream& stream, const std::string& source);

/// Whether a picture of colour is a JPEG file.
bool is_jpeg_stream(const OniStream& stream);

} // namespace kinora::formats
