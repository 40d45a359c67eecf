// Meshes of things and rooms about their own origin, in metres.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

namespace kinora::simulator {

struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> faces;
};

/// A parallelogram from `corner` along two sides, in small triangles.
Mesh plane(const Eigen::Vector3d& corner, const Eigen::Vector3d& along, const Eigen::Vector3d& across, int pieces);
Mesh box(const Eigen::Vector3d& half);
Mesh ball(double radius);
/// A profile of (height, radius) turned about y.
Mesh lathe(const std::vector<std::array<double, 2>>& profile);

} // namespace kinora::simulator
