// Meshes that move, as USD text.
// Source: Pixar, "USD glossary", UsdGeomMesh, UsdGeomXformable, UsdPreviewSurface specification 2.3.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/blended_mesh.h"
#include "common/facts.h"
#include "common/world_axes.h"
#include "kinora/plugin.h"

namespace kinora::formats {

struct UsdSettings {
  double frames_per_second = 0; ///< time codes per second; 0: as the poses follow one another
  int jpeg_quality = 92;        ///< of textures; 0: PNG
  WorldAxes axes;               ///< upAxis and metersPerUnit
};

/// NAME.usda with a mesh for each one given, and its texture beside it, NAME_MESH.jpg. A mesh that is still has no time
/// samples, one that follows a single joint has those of its transform, and one with weights those of its points:
/// joints are blended here, linearly. The root brings Kinora's axes and metres to those of the settings. Materials
/// shine by themselves. The files are written by finish(); the same meshes give the same bytes.
class UsdWriter {
public:
  /// Checks that the file can be written. Throws Error(kUnwritableOutput).
  UsdWriter(std::filesystem::path path, const UsdSettings& settings);

  /// The file's customLayerData.
  void describe(Facts facts) { facts_ = std::move(facts); }
  /// Throws Error(kUsage) if the mesh has a fault or follows a pose.
  void add(const KinoraMesh& mesh);
  /// Throws Error(kUsage) if there is no such mesh, its joints are not as many, or time does not increase.
  void pose(const KinoraMeshPose& pose);
  /// Throws Error: kFailure without a mesh or a pose of one that has joints, kUnwritableOutput.
  void finish();

private:
  [[noreturn]] void refuse(const std::string& what) const;

  std::filesystem::path path_;
  UsdSettings settings_;
  Facts facts_;
  std::vector<BlendedMesh> meshes_;
  bool posed_ = false;
};

} // namespace kinora::formats
