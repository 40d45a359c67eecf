// Meshes of one time as a Wavefront OBJ file.
// Source: Wavefront Technologies, "Object Files (.obj)", Advanced Visualizer manual, appendix B1; colours after the
// position of a vertex, as MeshLab, Blender and Houdini read them.
#pragma once

#include <filesystem>
#include <string>

#include "common/facts.h"
#include "common/world_axes.h"
#include "kinora/plugin.h"

namespace kinora::formats {

/// An object for each mesh: v x y z r g b (sRGB, 0 to 1), vn, f. The same meshes give the same bytes.
class ObjWriter {
public:
  /// Checks that the file can be written. Throws Error(kUnwritableOutput).
  ObjWriter(std::filesystem::path path, const WorldAxes& axes);

  /// Comments at the beginning; before all meshes.
  void describe(const Facts& facts) { text_ += lines_of(facts, "# "); }
  /// A mesh where it is in the world. Throws Error(kUsage) for one that has a fault or joints, or without colours.
  void add(const KinoraMesh& mesh);
  /// Writes the file, without vertices if there was no mesh. Throws Error(kUnwritableOutput).
  void finish() const;

private:
  std::filesystem::path path_;
  WorldAxes axes_;
  std::string text_;
  std::size_t vertex_count_ = 0;
};

} // namespace kinora::formats
