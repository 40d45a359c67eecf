// A mesh as it is in the world at one time.
#pragma once

#include "host/mesh_writer.h"
#include "motion/warp.h"

namespace kinora::bake {

/// Positions and normals of a canonical mesh (extract_mesh) carried along by the warp, without a skin; the rest is
/// copied. Every vertex is moved as the clip has it: dual quaternions, unlike the skins of mesh formats. What no node
/// moves stays where it is. Uses all threads; same bits for any number of them.
host::Mesh posed_mesh(const host::Mesh& canonical, const motion::Warp& warp);

} // namespace kinora::bake
