// What bends as one mesh with morph targets, whose weights are animated.
#pragma once

#include "common/blended_mesh.h"
#include "gltf/glb_scene.h"
#include "gltf/mesh_data.h"

namespace kinora::formats {

struct MorphSettings {
  std::size_t max_shapes = 24;
  bool quantize = true;
  Interpolation interpolation = Interpolation::kLinear;
};

/// Appends a base shape and those that are added to it (principal_shapes.h), and a node with them, whose
/// number it returns. The mesh has poses.
int add_morph_mesh(GlbBuffer& buffer, GlbScene& scene, const BlendedMesh& mesh, int material,
                   const MorphSettings& settings);

} // namespace kinora::formats
