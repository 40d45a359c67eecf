#include "bake/born_parts.h"

#include <algorithm>
#include <limits>

#include "core/parallel.h"

namespace kinora::bake {
namespace {

std::vector<std::uint32_t> births_of_faces(const host::Mesh& mesh, const clip::Layer& layer) {
  const motion::DeformationGraph& graph = *layer.motion.graph();
  std::vector<std::uint32_t> of_vertex(mesh.positions.size());
  parallel_for(of_vertex.size(), 4096, [&](const Chunk& chunk) {
    for (std::size_t v = chunk.begin; v < chunk.end; ++v)
      of_vertex[v] = layer.births.birth_of(graph.influence(mesh.positions[v].cast<double>()));
  });
  std::vector<std::uint32_t> births;
  births.reserve(mesh.faces.size());
  for (const auto& face : mesh.faces)
    births.push_back(std::max({of_vertex[face[0]], of_vertex[face[1]], of_vertex[face[2]]}));
  return births;
}

/// Of these births at most so many, the last among them, each standing for about as many triangles.
std::vector<std::uint32_t> chosen_births(std::vector<std::uint32_t> births, std::size_t most) {
  std::sort(births.begin(), births.end());
  std::vector<std::uint32_t> distinct = births;
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  if (distinct.size() <= most) return distinct;
  std::vector<std::uint32_t> chosen;
  if (births.front() == 0) chosen.push_back(0); // what is there from the start stays so
  const auto late = std::upper_bound(births.begin(), births.end(), 0U);
  const auto count = static_cast<std::size_t>(births.end() - late);
  const std::size_t parts = most - chosen.size();
  for (std::size_t i = 1; i <= parts; ++i) chosen.push_back(late[static_cast<std::ptrdiff_t>(count * i / parts - 1)]);
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return chosen;
}

template <class Row>
void copy_vertices(const std::vector<Row>& from, const std::vector<std::uint32_t>& vertices, std::vector<Row>& to) {
  if (from.empty()) return;
  to.reserve(vertices.size());
  for (const std::uint32_t v : vertices) to.push_back(from[v]);
}

/// The faces with numbers `which`, and their vertices.
host::Mesh piece_of(const host::Mesh& mesh, const std::vector<std::size_t>& which) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> number(mesh.positions.size(), kNone);
  std::vector<std::uint32_t> vertices;
  host::Mesh piece;
  piece.name = mesh.name;
  piece.texture = mesh.texture;
  for (const std::size_t f : which) {
    auto face = mesh.faces[f];
    for (std::uint32_t& v : face) {
      if (number[v] == kNone) {
        number[v] = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back(v);
      }
      v = number[v];
    }
    piece.faces.push_back(face);
  }
  copy_vertices(mesh.positions, vertices, piece.positions);
  copy_vertices(mesh.normals, vertices, piece.normals);
  copy_vertices(mesh.colors, vertices, piece.colors);
  copy_vertices(mesh.texture_coordinates, vertices, piece.texture_coordinates);
  return piece;
}

} // namespace

std::vector<BornPart> born_parts(host::Mesh mesh, const clip::Layer& layer, std::size_t max_parts) {
  std::vector<BornPart> parts;
  if (layer.births.are_at_the_start()) {
    parts.push_back({0, std::move(mesh)});
    return parts;
  }
  const std::vector<std::uint32_t> births = births_of_faces(mesh, layer);
  const std::vector<std::uint32_t> chosen = chosen_births(births, max_parts);
  if (chosen.size() == 1) {
    parts.push_back({chosen.front(), std::move(mesh)});
    return parts;
  }
  std::vector<std::vector<std::size_t>> faces(chosen.size());
  for (std::size_t f = 0; f < births.size(); ++f) {
    const auto part = std::lower_bound(chosen.begin(), chosen.end(), births[f]);
    faces[static_cast<std::size_t>(part - chosen.begin())].push_back(f);
  }
  for (std::size_t p = 0; p < chosen.size(); ++p) {
    parts.push_back({chosen[p], piece_of(mesh, faces[p])});
    if (p > 0) parts.back().mesh.name += " from frame " + std::to_string(chosen[p]);
  }
  return parts;
}

} // namespace kinora::bake
