// Meshes that move, through a format's writer.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "core/se3.h"
#include "host/open_writer.h"

namespace kinora::host {

/// How the vertices of a mesh hang on its joints. Index 0 and weight 0 where a vertex has fewer than four.
struct Skin {
  std::vector<SE3> inverse_bind; ///< per joint: the mesh's space to the joint's
  /// Per vertex; both empty if there is a single joint, which all vertices follow.
  std::vector<std::array<std::uint16_t, 4>> joints;
  std::vector<std::array<float, 4>> weights;
};

/// A surface in its own space; see KinoraMesh.
struct Mesh {
  std::string name; ///< unique within one output
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> normals;                  ///< unit length, outwards; one per vertex
  std::vector<std::array<std::uint8_t, 3>> colors;       ///< sRGB; one per vertex
  std::vector<std::array<std::uint32_t, 3>> faces;       ///< counterclockwise seen from outside
  std::vector<Eigen::Vector2f> texture_coordinates = {}; ///< one per vertex, or none; see KinoraMesh
  ColorImage texture = {};                               ///< 3 channels sRGB; then there are no colours
  Skin skin; ///< without joints: the mesh is still, and its space is the world
};

/// Moveable, one thread at a time. The format must outlive it. Writes exactly to the path that it is given.
class MeshWriter {
public:
  /// Throws what the plugin reports, and Error(kUsage) for options that the format does not declare or a format that
  /// writes no meshes. `facts`: for the file's metadata, if its format has a place for them.
  MeshWriter(const KinoraFormat& format, const std::filesystem::path& path, const Options& options,
             const Facts& facts = {});

  const KinoraFormat& format() const { return *format_; }
  /// All meshes come before the first pose. Returns the mesh's number.
  std::size_t add(const Mesh& mesh);
  /// Where the joints of a mesh are at a time, in seconds from the start, increasing for each mesh. Dropped where the
  /// format writes no skins. `hidden`: the mesh is not seen up to its next pose, where the format can say so.
  void pose(std::size_t mesh, double time, std::span<const SE3> joint_to_world, bool hidden = false);
  /// Completes the output. Nothing may be written afterwards.
  void finish() { finish_writer(*format_, writer_); }

private:
  const KinoraFormat* format_;
  WriterHandle writer_;
  std::size_t count_ = 0;
};

} // namespace kinora::host
