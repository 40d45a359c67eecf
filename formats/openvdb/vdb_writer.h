// A sparse volume as an OpenVDB file.
// Source: Museth, "VDB: High-resolution sparse volumes with dynamic topology", ACM TOG 32(3), 2013.
#pragma once

#include <filesystem>

#include "common/facts.h"
#include "common/world_axes.h"
#include "kinora/plugin.h"

namespace kinora::formats {

/// What programs call the grids.
struct VdbNames {
  const char* density;
  const char* color;
  const char* surface;
};

inline constexpr VdbNames kHoudiniNames = {"density", "Cd", "surface"};
inline constexpr VdbNames kBlenderNames = {"density", "color", "distance"};
inline constexpr VdbNames kUnrealNames = {"density", "color", "surface"};

struct VdbSettings {
  bool half_floats = true; ///< 16-bit numbers
  bool fog = true;
  bool surface = false;
  VdbNames names = kHoudiniNames;
  WorldAxes axes;
};

/// Writes a float grid of density (fog volume, extinction per unit of length), one of the distance to the surface
/// (level set, level_set.h), and a vector grid of colour (linear light). The same volume gives the same bytes.
class VdbWriter {
public:
  /// Checks that the file can be written. Throws Error(kUnwritableOutput).
  VdbWriter(std::filesystem::path path, const VdbSettings& settings);

  /// The file's metadata, beside the volume's own.
  void describe(Facts facts) { facts_ = std::move(facts); }
  /// Throws Error: kUsage for a second volume, one without "density", or a transform that has no inverse; kFailure if
  /// OpenVDB cannot store it; kUnwritableOutput.
  void write(const KinoraVolume& volume);
  /// Throws Error(kFailure) if there was no volume.
  void finish() const;

private:
  std::filesystem::path path_;
  VdbSettings settings_;
  Facts facts_;
  bool written_ = false;
};

} // namespace kinora::formats
