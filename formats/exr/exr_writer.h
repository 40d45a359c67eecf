// Pictures as OpenEXR files: a folder of them, or a single one.
// Source: Kainz, Bogart, Stanczyk, Hillman, "Technical Introduction to OpenEXR" (2013), channel names and attributes.
#pragma once

#include <optional>

#include "common/facts.h"
#include "common/picture_files.h"
#include "exr/exr_picture.h"

namespace kinora::formats {

/// Channels, as far as the picture has them: R G B A (half, linear light with the primaries of sRGB, multiplied by
/// alpha), Z (float, metres along the optical axis, 0 = nothing), N.X N.Y N.Z (half, out of the surface along the
/// camera's axes: x right, y up, z back), confidence (half, 0 to 1), id (unsigned: the label in front; the attribute
/// "labels" says what they mean). Attributes of the camera: worldToCamera (axes as above on both sides; x y z 1 as a
/// row before it) and fl_x fl_y cx cy with the centre of the first pixel at (0.5, 0.5). "time" is seconds from the
/// start. A picture that has layers gets NAME.deep.exr beside it (deep_picture.h). The same picture gives the same
/// bytes. Every file is complete once `write` returns; with `views_as_parts` pictures of one time are parts of one
/// file, NNNNNN.exr in the order of times, which is there when the next time begins.
class ExrWriter {
public:
  ExrWriter(PictureFiles files, ExrCompression compression, bool views_as_parts)
      : files_(std::move(files)), compression_(compression), views_as_parts_(views_as_parts) {}

  /// Attributes of every picture.
  void describe(Facts facts) { facts_ = std::move(facts); }
  /// Throws Error: kUnwritableOutput; kUsage for a second picture in a file, a name that leaves the folder, images
  /// of different sizes, or views of one time that follow a later one.
  void write(const KinoraPicture& picture);
  /// Throws Error: kUnwritableOutput, kFailure if a file was promised and no picture came.
  void finish();

private:
  ExrPicture described(const KinoraPicture& given, int width, int height) const;
  ExrPicture picture_of(const KinoraPicture& given) const;
  void hold(const KinoraPicture& given, ExrPicture picture);
  void write_views();

  PictureFiles files_;
  ExrCompression compression_;
  bool views_as_parts_;
  Facts facts_;
  std::optional<double> time_; ///< of the views that wait
  std::vector<ExrPicture> waiting_;
  std::vector<std::string> names_; ///< of those
  std::size_t written_ = 0;        ///< files with views
};

} // namespace kinora::formats
