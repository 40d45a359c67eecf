// What bends as a mesh for each pose.
#pragma once

#include "common/blended_mesh.h"
#include "gltf/glb_scene.h"
#include "gltf/mesh_data.h"

namespace kinora::formats {

/// Appends a mesh and a node for each pose: at any time one of the nodes has its size and all others have none. What
/// does not change is stored once, except by Draco. Returns the node above them. The mesh has poses.
int add_mesh_sequence(GlbBuffer& buffer, GlbScene& scene, const BlendedMesh& mesh, int material,
                      const GlbMeshSettings& settings);

} // namespace kinora::formats
