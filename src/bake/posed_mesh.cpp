#include "bake/posed_mesh.h"

#include "core/parallel.h"

namespace kinora::bake {

host::Mesh posed_mesh(const host::Mesh& canonical, const motion::Warp& warp) {
  host::Mesh mesh = canonical;
  mesh.skin = {};
  parallel_for(mesh.positions.size(), 4096, [&](const Chunk& chunk) {
    for (std::size_t v = chunk.begin; v < chunk.end; ++v) {
      const Eigen::Vector3d position = canonical.positions[v].cast<double>();
      const auto pose = warp.is_rigid() ? warp.rigid() : warp.at(position);
      if (!pose) continue;
      mesh.positions[v] = (*pose * position).cast<float>();
      mesh.normals[v] = (pose->linear() * canonical.normals[v].cast<double>()).cast<float>();
    }
  });
  return mesh;
}

} // namespace kinora::bake
