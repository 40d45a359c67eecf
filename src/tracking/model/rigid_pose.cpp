#include "tracking/model/rigid_pose.h"

#include <Eigen/SVD>
#include <Eigen/SparseCholesky>

namespace kinora::tracking {
namespace {

constexpr int kSweeps = 20; // each turns nodes and then moves them

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
  return u * svd.matrixV().transpose();
}

} // namespace

std::vector<SE3> rigid_pose(std::span<const Eigen::Vector3d> nodes, std::span<const GraphEdge> edges,
                            std::span<const SE3> targets, double pull) {
  const auto count = static_cast<Eigen::Index>(nodes.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index n = 0; n < count; ++n) entries.emplace_back(n, n, pull);
  for (const GraphEdge& edge : edges) {
    entries.emplace_back(edge.a, edge.a, 1);
    entries.emplace_back(edge.b, edge.b, 1);
    entries.emplace_back(edge.a, edge.b, -1);
    entries.emplace_back(edge.b, edge.a, -1);
  }
  Eigen::SparseMatrix<double> system(count, count);
  system.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(system);

  Eigen::MatrixX3d pulled(count, 3);
  std::vector<Eigen::Matrix3d> turns;
  for (Eigen::Index n = 0; n < count; ++n) {
    const auto i = static_cast<std::size_t>(n);
    pulled.row(n) = (targets[i] * nodes[i]).transpose();
    turns.push_back(targets[i].linear());
  }
  Eigen::MatrixX3d places = pulled;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    std::vector<Eigen::Matrix3d> spreads(nodes.size(), Eigen::Matrix3d::Zero());
    for (const GraphEdge& edge : edges) {
      const auto a = static_cast<std::size_t>(edge.a);
      const auto b = static_cast<std::size_t>(edge.b);
      const Eigen::Matrix3d spread =
          (places.row(edge.b) - places.row(edge.a)).transpose() * (nodes[b] - nodes[a]).transpose();
      spreads[a] += spread;
      spreads[b] += spread;
    }
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      // One that has few neighbours keeps what they do not tell of its turn.
      const double unsure = 1e-3 * spreads[n].norm() + 1e-12;
      turns[n] = nearest_rotation(spreads[n] + unsure * turns[n]);
    }
    Eigen::MatrixX3d sides = pull * pulled;
    for (const GraphEdge& edge : edges) {
      const auto a = static_cast<std::size_t>(edge.a);
      const auto b = static_cast<std::size_t>(edge.b);
      const Eigen::Vector3d along = 0.5 * (turns[a] + turns[b]) * (nodes[b] - nodes[a]);
      sides.row(edge.b) += along.transpose();
      sides.row(edge.a) -= along.transpose();
    }
    places = solver.solve(sides);
  }
  std::vector<SE3> pose(nodes.size(), SE3::Identity());
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    pose[n].linear() = turns[n];
    pose[n].translation() = places.row(static_cast<Eigen::Index>(n)).transpose() - turns[n] * nodes[n];
  }
  return pose;
}

} // namespace kinora::tracking
