// A mesh as Draco packs it.
// Source: Khronos Group, KHR_draco_mesh_compression; Rossignac, "Edgebreaker: Connectivity Compression for Triangle
// Meshes", IEEE TVCG 5(1), 1999.
#pragma once

#include <nlohmann/json.hpp>

#include "gltf/glb_buffer.h"
#include "gltf/mesh_attributes.h"

namespace kinora::formats {

/// Appends the mesh and returns its primitive, without a material. Positions keep 14 bits of the mesh's largest side,
/// texture coordinates 12, normals 8. Throws Error(kFailure) if Draco cannot.
nlohmann::json draco_primitive(GlbBuffer& buffer, const MeshAttributes& mesh);

} // namespace kinora::formats
