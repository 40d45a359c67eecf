#include "bake/flat_surface.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace kinora::bake {
namespace {

constexpr float kSeen = 0.1F; ///< confidence from which a side was seen
constexpr int kRimRings = 6;  ///< rings of vertices around what was seen that stay: they make the outline
constexpr int kRounds = 100;
constexpr double kReach = 0.05; ///< metres

std::vector<std::uint8_t> unseen_vertices(const fields::FieldBox& box, const fields::Confidence& confidence,
                                          const Triangles& triangles) {
  const std::vector<Eigen::Vector3d> normals = vertex_normals(triangles);
  std::vector<std::uint8_t> unseen(triangles.positions.size());
  for (std::size_t v = 0; v < unseen.size(); ++v) {
    const Eigen::Vector3f at = ((triangles.positions[v] - box.origin) / box.side).cast<float>();
    unseen[v] = confidence.at({at.x(), at.y(), at.z()}, normals[v].cast<float>()) < kSeen ? 1 : 0;
  }
  for (int ring = 0; ring < kRimRings; ++ring) {
    const std::vector<std::uint8_t> before = unseen;
    for (const auto& face : triangles.faces) {
      if (std::ranges::all_of(face, [&](std::uint32_t v) { return before[v] != 0; })) continue;
      for (const std::uint32_t v : face) unseen[v] = 0;
    }
  }
  return unseen;
}

} // namespace

bool is_flat(const Triangles& triangles, double height) {
  constexpr std::size_t kThousand = 1000;
  const auto count = static_cast<double>(triangles.positions.size());
  if (triangles.positions.empty()) return false;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : triangles.positions) mean += p / count;
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : triangles.positions) moments += (p - mean) * (p - mean).transpose() / count;
  const Eigen::Vector3d normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(moments).eigenvectors().col(0);
  const auto outside = std::ranges::count_if(
      triangles.positions, [&](const Eigen::Vector3d& p) { return std::abs(normal.dot(p - mean)) > height; });
  return static_cast<std::size_t>(outside) <= triangles.positions.size() / kThousand;
}

void smooth_unseen(const fields::FieldBox& box, const fields::Confidence& confidence, Triangles& triangles) {
  const std::vector<std::uint8_t> unseen = unseen_vertices(box, confidence, triangles);
  const std::vector<Eigen::Vector3d> given = triangles.positions;
  std::vector<double> neighbours(given.size());
  std::vector<std::array<std::uint32_t, 3>> corners; // an unseen vertex and the two others of a face
  for (const auto& face : triangles.faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (unseen[face[k]] == 0) continue;
      corners.push_back({face[k], face[(k + 1) % 3], face[(k + 2) % 3]});
      neighbours[face[k]] += 2;
    }
  }
  std::vector<Eigen::Vector3d> sums(given.size());
  for (int round = 0; round < kRounds; ++round) {
    std::ranges::fill(sums, Eigen::Vector3d::Zero());
    for (const auto& [v, a, b] : corners) sums[v] += triangles.positions[a] + triangles.positions[b];
    for (std::size_t v = 0; v < given.size(); ++v) {
      if (unseen[v] == 0 || !(neighbours[v] > 0)) continue;
      Eigen::Vector3d way = sums[v] / neighbours[v] - given[v];
      if (way.norm() > kReach) way *= kReach / way.norm();
      triangles.positions[v] = given[v] + way;
    }
  }
}

} // namespace kinora::bake
