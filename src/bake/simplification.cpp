#include "bake/simplification.h"

#include <meshoptimizer.h>

namespace kinora::bake {

void simplify(Triangles& triangles, double max_error, std::size_t min_faces) {
  if (triangles.faces.size() <= min_faces) return;
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(triangles.positions.size());
  for (const Eigen::Vector3d& p : triangles.positions) positions.emplace_back(p.cast<float>());
  const float* numbers = positions.front().data();
  const float scale = meshopt_simplifyScale(numbers, positions.size(), sizeof(Eigen::Vector3f));
  std::vector<std::array<std::uint32_t, 3>> faces(triangles.faces.size());
  const std::size_t indices = meshopt_simplify(faces.front().data(), triangles.faces.front().data(), 3 * faces.size(),
                                               numbers, positions.size(), sizeof(Eigen::Vector3f), 3 * min_faces,
                                               static_cast<float>(max_error) / scale, 0, nullptr);
  faces.resize(indices / 3);
  triangles.faces = std::move(faces);
  keep_vertices(triangles, std::vector<std::uint8_t>(triangles.positions.size(), 1));
}

} // namespace kinora::bake
