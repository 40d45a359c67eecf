// The geometry of a mesh in the form that glTF stores.
#pragma once

#include <array>

#include <nlohmann/json.hpp>

#include "gltf/glb_buffer.h"
#include "kinora/plugin.h"

namespace kinora::formats {

/// How a mesh is stored.
struct GlbMeshSettings {
  bool quantize = true; ///< KHR_mesh_quantization: 16 bits for positions and texture coordinates, 8 for normals
  bool draco = false;   ///< KHR_draco_mesh_compression, which quantizes by itself
};

struct GlbMesh {
  nlohmann::json entry; ///< of "meshes"
  /// What carries positions as they are stored to those that were given: p · scale + offset, along each axis alike.
  float scale = 1;
  std::array<float, 3> offset{};
};

/// Appends the mesh, which must be without fault. Vertices of a mesh that has joints but no weights are given in the
/// space of its joint.
GlbMesh add_mesh(GlbBuffer& buffer, const KinoraMesh& mesh, int material, const GlbMeshSettings& settings);

} // namespace kinora::formats
