// Meshes of one time as a Wavefront OBJ file.
// Source: Wavefront Technologies, "Object Files (.obj)", Advanced Visualizer manual, appendix B1; colours after the
// position of a vertex, as MeshLab, Blender and Houdini read them.
#pragma once

#include <filesystem>
#include <string>

#include "kinora/plugin.h"

namespace kinora::formats {

/// An object for each mesh: v x y z r g b (sRGB, 0 to 1), vn, f. Axes are those of glTF: x right, y up, z backward,
/// metres. The same meshes give the same bytes.
class ObjWriter {
public:
  /// Checks that the file can be written. Throws Error(kUnwritableOutput).
  explicit ObjWriter(std::filesystem::path path);

  /// A mesh where it is in the world. Throws Error(kUsage) for one that has a fault or joints, or without colours.
  void add(const KinoraMesh& mesh);
  /// Writes the file. Throws Error: kFailure if there was no mesh; kUnwritableOutput.
  void finish() const;

private:
  std::filesystem::path path_;
  std::string text_;
  std::size_t vertex_count_ = 0;
};

} // namespace kinora::formats
