// The geometry of a mesh in the form that glTF stores.
#pragma once

#include <array>
#include <span>

#include <nlohmann/json.hpp>

#include "gltf/glb_buffer.h"
#include "gltf/mesh_attributes.h"
#include "kinora/plugin.h"

namespace kinora::formats {

/// How a mesh is stored.
struct GlbMeshSettings {
  bool quantize = true; ///< KHR_mesh_quantization: 16 bits for positions and texture coordinates, 8 for normals
  bool draco = false;   ///< KHR_draco_mesh_compression, which quantizes by itself
};

/// What carries positions as they are stored to those that were given: p · scale + offset, along each axis alike.
struct GlbBox {
  float scale = 1;
  std::array<float, 3> offset{};

  /// What a node needs for it: "scale" and "translation", or nothing.
  nlohmann::json node() const;
};

/// The smallest cube around positions, x y z of each, from their least corner on.
GlbBox cube_around(std::span<const float> positions);

struct GlbMesh {
  nlohmann::json entry; ///< of "meshes"
  GlbBox box;
};

/// Appends the mesh, which must be without fault. Vertices of a mesh that has joints but no weights are given in the
/// space of its joint.
GlbMesh add_mesh(GlbBuffer& buffer, const KinoraMesh& mesh, int material, const GlbMeshSettings& settings);

/// Appends a mesh that Draco does not pack, and returns its primitive, without a material. With `quantize`, positions
/// are stored in 1/65535 of the box, which must hold them.
nlohmann::json plain_primitive(GlbBuffer& buffer, const MeshAttributes& mesh, bool quantize, const GlbBox& box);

/// Appends positions alone, and returns their accessor.
int add_positions(GlbBuffer& buffer, const std::vector<float>& positions, bool quantize, const GlbBox& box);

} // namespace kinora::formats
