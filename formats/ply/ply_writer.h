// Meshes of one time as a PLY file.
// Source: Turk, "The PLY Polygon File Format", 1994.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/facts.h"
#include "common/world_axes.h"
#include "kinora/plugin.h"

namespace kinora::formats {

enum class PlyContent {
  kMesh,   ///< vertices with normals and colours, and triangles
  kPoints, ///< the vertices alone
  kSplats, ///< a Gaussian for each vertex (splats.h)
};

/// Binary, little endian. All meshes become one list of vertices: x y z nx ny nz red green blue. Splats have the axes
/// of their tools, which are Kinora's, and metres. The same meshes give the same bytes.
class PlyWriter {
public:
  /// Checks that the file can be written. Throws Error(kUnwritableOutput).
  PlyWriter(std::filesystem::path path, PlyContent content, const WorldAxes& axes);

  /// Comments of the header.
  void describe(Facts facts) { facts_ = std::move(facts); }
  /// A mesh where it is in the world. Throws Error(kUsage) for one that has a fault or joints, or without colours.
  void add(const KinoraMesh& mesh);
  /// Writes the file, without vertices if there was no mesh. Throws Error(kUnwritableOutput).
  void finish() const;

private:
  void append_splats(const KinoraMesh& mesh);

  std::filesystem::path path_;
  PlyContent content_;
  WorldAxes axes_;
  Facts facts_;
  std::vector<std::byte> vertices_;
  std::vector<std::byte> faces_;
  std::uint32_t vertex_count_ = 0;
  std::size_t face_count_ = 0;
};

} // namespace kinora::formats
