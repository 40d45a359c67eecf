// Pictures as OpenEXR files: a folder of them, or a single one.
// Source: Kainz, Bogart, Stanczyk, Hillman, "Technical Introduction to OpenEXR" (2013), channel names and attributes.
#pragma once

#include "common/picture_files.h"
#include "exr/exr_picture.h"

namespace kinora::formats {

/// Channels, as far as the picture has them: R G B A (half, linear light with the primaries of sRGB, multiplied by
/// alpha), Z (float, metres along the optical axis, 0 = nothing), N.X N.Y N.Z (half, out of the surface along the
/// camera's axes: x right, y up, z back), confidence (half, 0 to 1), id (unsigned: the label in front; the attribute
/// "labels" says what they mean). Attributes of the camera: worldToCamera (axes as above on both sides; x y z 1 as a
/// row before it) and fl_x fl_y cx cy with the centre of the first pixel at (0.5, 0.5). "time" is seconds from the
/// start. The same picture gives the same bytes. Every file is complete once `write` returns.
class ExrWriter {
public:
  ExrWriter(PictureFiles files, ExrCompression compression) : files_(std::move(files)), compression_(compression) {}

  /// Throws Error: kUnwritableOutput; kUsage for a second picture in a file, a name that leaves the folder, or images
  /// of different sizes.
  void write(const KinoraPicture& picture);
  /// Throws Error(kFailure) if a file was promised and no picture came.
  void finish() const { files_.finish(); }

private:
  PictureFiles files_;
  ExrCompression compression_;
};

} // namespace kinora::formats
