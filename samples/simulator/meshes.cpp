#include "meshes.h"

#include <cmath>
#include <numbers>

namespace kinora::simulator {
namespace {

using Vec = Eigen::Vector3d;

constexpr int kAround = 32;

void add(const Mesh& part, Mesh& whole) {
  const auto first = static_cast<int>(whole.vertices.size());
  whole.vertices.insert(whole.vertices.end(), part.vertices.begin(), part.vertices.end());
  for (const auto& face : part.faces) whole.faces.push_back({first + face[0], first + face[1], first + face[2]});
}

/// The triangles of a grid of (rows + 1) × (columns + 1) vertices, row by row.
void join_grid(int rows, int columns, Mesh& mesh) {
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const int a = r * (columns + 1) + c;
      const int b = a + columns + 1;
      mesh.faces.push_back({a, b, a + 1});
      mesh.faces.push_back({a + 1, b, b + 1});
    }
  }
}

} // namespace

Mesh plane(const Vec& corner, const Vec& along, const Vec& across, int pieces) {
  Mesh mesh;
  for (int r = 0; r <= pieces; ++r)
    for (int c = 0; c <= pieces; ++c)
      mesh.vertices.emplace_back(corner + along * (static_cast<double>(r) / pieces) +
                                 across * (static_cast<double>(c) / pieces));
  join_grid(pieces, pieces, mesh);
  return mesh;
}

Mesh box(const Vec& half) {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec normal = half[axis] * Vec::Unit(axis);
    const Vec along = 2 * half[(axis + 1) % 3] * Vec::Unit((axis + 1) % 3);
    const Vec across = 2 * half[(axis + 2) % 3] * Vec::Unit((axis + 2) % 3);
    for (const double side : {-1.0, 1.0}) add(plane(side * normal - along / 2 - across / 2, along, across, 4), mesh);
  }
  return mesh;
}

Mesh lathe(const std::vector<std::array<double, 2>>& profile) {
  Mesh mesh;
  for (const auto& [height, radius] : profile) {
    for (int i = 0; i <= kAround; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAround;
      mesh.vertices.emplace_back(radius * std::cos(angle), height, radius * std::sin(angle));
    }
  }
  join_grid(static_cast<int>(profile.size()) - 1, kAround, mesh);
  return mesh;
}

Mesh ball(double radius) {
  std::vector<std::array<double, 2>> profile;
  constexpr int kRings = 20;
  for (int i = 0; i <= kRings; ++i) {
    const double angle = std::numbers::pi * i / kRings;
    profile.push_back({-radius * std::cos(angle), radius * std::sin(angle)});
  }
  return lathe(profile);
}

} // namespace kinora::simulator
