#include "tracking/model/arap_deformation.h"

#include <Eigen/SVD>
#include <Eigen/SparseCholesky>

namespace kinora::tracking {
namespace {

constexpr int kIterations = 20; // each turns nodes and then moves them

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
  return u * svd.matrixV().transpose();
}

} // namespace

std::vector<SE3> arap_deform(std::span<const Eigen::Vector3d> nodes, std::span<const GraphEdge> edges,
                             std::span<const SE3> targets, double target_weight) {
  const auto count = static_cast<Eigen::Index>(nodes.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index n = 0; n < count; ++n) entries.emplace_back(n, n, target_weight);
  for (const GraphEdge& edge : edges) {
    entries.emplace_back(edge.a, edge.a, 1);
    entries.emplace_back(edge.b, edge.b, 1);
    entries.emplace_back(edge.a, edge.b, -1);
    entries.emplace_back(edge.b, edge.a, -1);
  }
  Eigen::SparseMatrix<double> system(count, count);
  system.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(system);

  Eigen::MatrixX3d target_positions(count, 3);
  std::vector<Eigen::Matrix3d> rotations;
  for (Eigen::Index n = 0; n < count; ++n) {
    const auto i = static_cast<std::size_t>(n);
    target_positions.row(n) = (targets[i] * nodes[i]).transpose();
    rotations.push_back(targets[i].linear());
  }
  Eigen::MatrixX3d positions = target_positions;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    std::vector<Eigen::Matrix3d> covariances(nodes.size(), Eigen::Matrix3d::Zero());
    for (const GraphEdge& edge : edges) {
      const auto a = static_cast<std::size_t>(edge.a);
      const auto b = static_cast<std::size_t>(edge.b);
      const Eigen::Matrix3d covariance =
          (positions.row(edge.b) - positions.row(edge.a)).transpose() * (nodes[b] - nodes[a]).transpose();
      covariances[a] += covariance;
      covariances[b] += covariance;
    }
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      // One that has few neighbours keeps what they do not tell of its turn.
      const double regularisation = 1e-3 * covariances[n].norm() + 1e-12;
      rotations[n] = nearest_rotation(covariances[n] + regularisation * rotations[n]);
    }
    Eigen::MatrixX3d right_side = target_weight * target_positions;
    for (const GraphEdge& edge : edges) {
      const auto a = static_cast<std::size_t>(edge.a);
      const auto b = static_cast<std::size_t>(edge.b);
      const Eigen::Vector3d along = 0.5 * (rotations[a] + rotations[b]) * (nodes[b] - nodes[a]);
      right_side.row(edge.b) += along.transpose();
      right_side.row(edge.a) -= along.transpose();
    }
    positions = solver.solve(right_side);
  }
  std::vector<SE3> pose(nodes.size(), SE3::Identity());
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    pose[n].linear() = rotations[n];
    pose[n].translation() = positions.row(static_cast<Eigen::Index>(n)).transpose() - rotations[n] * nodes[n];
  }
  return pose;
}

} // namespace kinora::tracking
