#include "ply/splats.h"

#include <cmath>

#include <Eigen/Core>

namespace kinora::formats {
namespace {

constexpr float kWidth = 0.6F;    ///< standard deviation, in sides of triangles
constexpr float kFlatness = 0.1F; ///< standard deviation along the normal, of that across
constexpr float kOpacity = 0.98F;
constexpr float kSmallest = 1e-5F; ///< metres

/// Per vertex, the mean length of the triangles' sides at it.
std::vector<float> side_lengths(const KinoraMesh& mesh) {
  std::vector<float> sums(mesh.vertex_count);
  std::vector<float> counts(mesh.vertex_count);
  const auto position = [&mesh](std::uint32_t v) { return Eigen::Map<const Eigen::Vector3f>(mesh.positions + 3 * v); };
  for (std::size_t f = 0; f < mesh.face_count; ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.faces[3 * f + k];
      const std::uint32_t b = mesh.faces[3 * f + (k + 1) % 3];
      const float length = (position(a) - position(b)).norm();
      for (const std::uint32_t v : {a, b}) {
        sums[v] += length;
        counts[v] += 1;
      }
    }
  }
  for (std::size_t v = 0; v < sums.size(); ++v) sums[v] /= std::max(counts[v], 1.0F);
  return sums;
}

/// The shortest rotation of the third axis to a unit vector; w x y z.
std::array<float, 4> rotation_to(const float* normal) {
  const float w = 1 + normal[2];
  if (w < 1e-6F) return {0, 1, 0, 0};
  const float length = std::sqrt(w * w + normal[0] * normal[0] + normal[1] * normal[1]);
  return {w / length, -normal[1] / length, normal[0] / length, 0};
}

} // namespace

std::vector<Splat> splats_of(const KinoraMesh& mesh) {
  constexpr float kHarmonic = 0.28209479F; // 1 / (2 √π)
  const std::vector<float> sides = side_lengths(mesh);
  std::vector<Splat> splats(mesh.vertex_count);
  for (std::size_t v = 0; v < splats.size(); ++v) {
    Splat& splat = splats[v];
    for (std::size_t a = 0; a < 3; ++a) {
      splat.position[a] = mesh.positions[3 * v + a];
      splat.normal[a] = mesh.normals[3 * v + a];
      splat.color[a] = (static_cast<float>(mesh.colors[3 * v + a]) / 255 - 0.5F) / kHarmonic;
      const float width = std::max(kWidth * sides[v], kSmallest);
      splat.scale[a] = std::log(a == 2 ? kFlatness * width : width);
    }
    splat.opacity = std::log(kOpacity / (1 - kOpacity));
    const auto rotation = rotation_to(splat.normal);
    std::copy(rotation.begin(), rotation.end(), splat.rotation);
  }
  return splats;
}

} // namespace kinora::formats
