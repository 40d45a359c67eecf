// The geometry of a mesh in the form that glTF stores.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "gltf/glb_buffer.h"
#include "kinora/plugin.h"

namespace kinora::formats {

/// What is wrong with a mesh; empty if nothing.
std::string fault_of(const KinoraMesh& mesh);

/// Appends the mesh and returns its "meshes" entry; material 0. Vertices of a mesh that has joints but no weights are
/// given in the space of its joint. The mesh must be without fault.
nlohmann::json add_mesh(GlbBuffer& buffer, const KinoraMesh& mesh);

/// sRGB byte to linear light in 0…65535 (IEC 61966-2-1), which is what COLOR_0 holds.
std::uint16_t linear_color(std::uint8_t srgb);

} // namespace kinora::formats
