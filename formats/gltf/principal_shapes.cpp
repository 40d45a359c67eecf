#include "gltf/principal_shapes.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace kinora::formats {
namespace {

constexpr double kUnseen = 1e-4; ///< metres

Eigen::VectorXd coordinates(const BlendedMesh& mesh, std::size_t pose) {
  const std::vector<Eigen::Vector3f> points = mesh.points(pose);
  return Eigen::Map<const Eigen::VectorXf>(points.front().data(), 3 * static_cast<Eigen::Index>(points.size()))
      .cast<double>();
}

/// A column for each of at most kMaxShapes poses, spread over all.
Eigen::MatrixXd spread_poses(const BlendedMesh& mesh) {
  const std::size_t poses = mesh.times().size();
  const std::size_t count = std::min(poses, kMaxShapes);
  Eigen::MatrixXd columns(3 * static_cast<Eigen::Index>(mesh.positions.size()), static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i)
    columns.col(static_cast<Eigen::Index>(i)) =
        coordinates(mesh, i * (poses - 1) / std::max<std::size_t>(1, count - 1));
  return columns;
}

/// Orthonormal columns that span what the offsets do, the most moving first.
Eigen::MatrixXd principal_directions(const Eigen::MatrixXd& offsets, std::size_t most) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(offsets.transpose() * offsets); // values increase
  const Eigen::VectorXd energy = solver.eigenvalues().cwiseMax(0).reverse();
  const double enough = kUnseen * kUnseen * static_cast<double>(offsets.size()) / 3;
  double left = energy.sum();
  Eigen::Index count = 0;
  while (count < std::min<Eigen::Index>(energy.size(), static_cast<Eigen::Index>(most)) && left > enough)
    left -= energy[count++];
  Eigen::MatrixXd directions = offsets * solver.eigenvectors().rightCols(count).rowwise().reverse();
  for (Eigen::Index k = 0; k < count; ++k) directions.col(k) /= std::sqrt(energy[k]);
  return directions;
}

} // namespace

PrincipalShapes principal_shapes(const BlendedMesh& mesh, std::size_t most) {
  Eigen::MatrixXd offsets = spread_poses(mesh);
  Eigen::VectorXd base = offsets.rowwise().mean();
  offsets.colwise() -= base;
  Eigen::MatrixXd directions = principal_directions(offsets, most);
  const auto poses = static_cast<Eigen::Index>(mesh.times().size());
  Eigen::MatrixXd weights(directions.cols(), poses);
  double squares = 0;
  for (Eigen::Index i = 0; i < poses; ++i) {
    const Eigen::VectorXd offset = coordinates(mesh, static_cast<std::size_t>(i)) - base;
    weights.col(i) = directions.transpose() * offset;
    squares += (offset - directions * weights.col(i)).squaredNorm();
  }
  PrincipalShapes made;
  made.error = std::sqrt(squares / static_cast<double>(mesh.positions.size()) / static_cast<double>(poses));
  for (Eigen::Index k = 0; k < directions.cols(); ++k) {
    const double least = weights.row(k).minCoeff();
    const double range = weights.row(k).maxCoeff() - least;
    weights.row(k) = (weights.row(k).array() - least) / range;
    base += least * directions.col(k);
    const Eigen::VectorXf shape = (range * directions.col(k)).cast<float>();
    made.shapes.emplace_back(shape.begin(), shape.end());
  }
  const Eigen::VectorXf floats = base.cast<float>();
  made.base.assign(floats.begin(), floats.end());
  for (Eigen::Index i = 0; i < poses; ++i)
    for (Eigen::Index k = 0; k < weights.rows(); ++k) made.weights.push_back(static_cast<float>(weights(k, i)));
  return made;
}

} // namespace kinora::formats
