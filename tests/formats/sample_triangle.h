// Small meshes for the writers of meshes of one time.
#pragma once

#include "host/mesh_writer.h"
#include "host/plugin_table.h"

namespace kinora::test {

/// One triangle, `x` metres to the right.
inline host::Mesh triangle(const std::string& name, float x) {
  host::Mesh mesh;
  mesh.name = name;
  mesh.positions = {{x, 0, 2}, {x + 0.1F, 0, 2}, {x, 0.5F, 2}};
  mesh.normals = {{0, 0, -1}, {0, 0, -1}, {0, 0.6F, -0.8F}};
  mesh.colors = {{0, 0, 0}, {255, 255, 255}, {200, 100, 50}};
  mesh.faces = {{0, 1, 2}};
  return mesh;
}

inline void write_meshes(const KinoraFormat& format, const std::filesystem::path& path, const host::Options& options,
                         const std::vector<host::Mesh>& meshes, const host::Facts& facts = {}) {
  host::MeshWriter writer(format, path, options, facts);
  for (const host::Mesh& mesh : meshes) writer.add(mesh);
  writer.finish();
}

} // namespace kinora::test
