// A sparse volume as an OpenVDB file.
// Source: Museth, "VDB: High-resolution sparse volumes with dynamic topology", ACM TOG 32(3), 2013.
#pragma once

#include <filesystem>

#include "kinora/plugin.h"

namespace kinora::formats {

/// Writes a fog volume: the float grid "density" (extinction per metre) and the vector grid "Cd" (colour, linear
/// light). Axes are those of glTF: x right, y up, z backward, metres. The same volume gives the same bytes.
class VdbWriter {
public:
  /// Checks that the file can be written. Throws Error(kUnwritableOutput). `half_floats`: 16-bit numbers.
  VdbWriter(std::filesystem::path path, bool half_floats);

  /// Throws Error: kUsage for a second volume, one without "density", or a transform that has no inverse; kFailure if
  /// OpenVDB cannot store it; kUnwritableOutput.
  void write(const KinoraVolume& volume);
  /// Throws Error(kFailure) if there was no volume.
  void finish() const;

private:
  std::filesystem::path path_;
  bool half_;
  bool written_ = false;
};

} // namespace kinora::formats
