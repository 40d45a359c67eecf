#include "tracking/camera/pose_graph.h"

#include <Eigen/SparseCholesky>

#include "core/error.h"

namespace kinora::tracking {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kIterations = 20;
constexpr double kConverged = 1e-7; // metres, of the largest step
// Keeps what no edge ties in its place; against an edge's information of one it moves nothing else.
constexpr double kAnchor = 1e-9;

// Carries a twist along with its space: T · exp(ξ) · T⁻¹ = exp(Ad(T) · ξ).
Matrix6 adjoint(const SE3& t) {
  Matrix6 result = Matrix6::Zero();
  result.topLeftCorner<3, 3>() = t.linear();
  result.bottomRightCorner<3, 3>() = t.linear();
  result.topRightCorner<3, 3>() = skew(t.translation()) * t.linear();
  return result;
}

Twist scale_of(double lever) {
  Twist scale = Twist::Ones();
  scale.tail<3>().setConstant(lever);
  return scale;
}

} // namespace

Twist edge_error(const PoseEdge& edge, const SE3& from, const SE3& to, double lever) {
  return scale_of(lever).cwiseProduct(log_se3(edge.to_in_from.inverse() * from.inverse() * to));
}

void optimise_poses(std::span<const PoseEdge> edges, double lever, std::vector<SE3>& poses) {
  for (const PoseEdge& edge : edges) {
    if (edge.from >= poses.size() || edge.to >= poses.size()) {
      throw Error(ErrorCode::kFailure, "an edge between camera poses names one that does not exist");
    }
  }
  if (poses.size() < 2 || edges.empty()) return;
  const auto size = static_cast<Eigen::Index>(6 * (poses.size() - 1)); // the first pose stays
  const Twist scale = scale_of(lever);
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
  for (int i = 0; i < kIterations; ++i) {
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
    const auto add = [&](std::size_t row, std::size_t column, const Matrix6& block) {
      if (row == 0 || column == 0) return;
      for (int r = 0; r < 6; ++r) {
        for (int c = 0; c < 6; ++c) {
          entries.emplace_back(static_cast<int>(6 * (row - 1)) + r, static_cast<int>(6 * (column - 1)) + c,
                               block(r, c));
        }
      }
    };
    for (Eigen::Index k = 0; k < size; ++k) entries.emplace_back(static_cast<int>(k), static_cast<int>(k), kAnchor);
    for (const PoseEdge& edge : edges) {
      // Poses are moved by T · exp(ξ); the logarithm's own derivative is one to the size of the error.
      const SE3& from = poses[edge.from];
      const SE3& to = poses[edge.to];
      const Twist error = edge_error(edge, from, to, lever);
      const Matrix6 by_from = -(scale.asDiagonal() * adjoint(to.inverse() * from));
      const Matrix6 by_to = scale.asDiagonal();
      const Matrix6 weighted_from = edge.weight * by_from.transpose();
      const Matrix6 weighted_to = edge.weight * by_to.transpose();
      add(edge.from, edge.from, weighted_from * by_from);
      add(edge.from, edge.to, weighted_from * by_to);
      add(edge.to, edge.from, weighted_to * by_from);
      add(edge.to, edge.to, weighted_to * by_to);
      if (edge.from > 0) {
        gradient.segment<6>(static_cast<Eigen::Index>(6 * (edge.from - 1))) += weighted_from * error;
      }
      if (edge.to > 0) gradient.segment<6>(static_cast<Eigen::Index>(6 * (edge.to - 1))) += weighted_to * error;
    }
    Eigen::SparseMatrix<double> information(size, size);
    information.setFromTriplets(entries.begin(), entries.end());
    solver.compute(information);
    const Eigen::VectorXd step = solver.solve(-gradient);
    if (solver.info() != Eigen::Success || !step.allFinite()) return;
    for (std::size_t p = 1; p < poses.size(); ++p) {
      poses[p] = renormalized(poses[p] * exp_se3(step.segment<6>(static_cast<Eigen::Index>(6 * (p - 1)))));
    }
    if (step.lpNorm<Eigen::Infinity>() < kConverged) return;
  }
}

} // namespace kinora::tracking
