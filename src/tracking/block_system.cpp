#include "tracking/block_system.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace kinora::tracking {
namespace {

void multiply(const BlockPattern& pattern, const BlockSystem& system, std::span<const Twist> x,
              std::vector<Twist>& result) {
  for (std::size_t row = 0; row < pattern.node_count(); ++row) {
    Twist sum = Twist::Zero();
    for (std::size_t b = pattern.row_begin(row); b < pattern.row_end(row); ++b) {
      sum.noalias() += system.blocks[b] * x[static_cast<std::size_t>(pattern.column(b))];
    }
    result[row] = sum;
  }
}

double dot(std::span<const Twist> a, std::span<const Twist> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

} // namespace

BlockPattern::BlockPattern(std::size_t nodes, std::span<const Pair> pairs) : begin_(nodes + 1) {
  std::vector<std::vector<int>> rows(nodes);
  for (std::size_t i = 0; i < nodes; ++i) rows[i].push_back(static_cast<int>(i));
  for (const Pair& pair : pairs) {
    rows[static_cast<std::size_t>(pair.a)].push_back(pair.b);
    rows[static_cast<std::size_t>(pair.b)].push_back(pair.a);
  }
  for (std::size_t i = 0; i < nodes; ++i) {
    std::vector<int>& row = rows[i];
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    columns_.insert(columns_.end(), row.begin(), row.end());
    begin_[i + 1] = columns_.size();
  }
}

std::size_t BlockPattern::find(int row, int column) const {
  const auto first = columns_.begin() + static_cast<std::ptrdiff_t>(begin_[static_cast<std::size_t>(row)]);
  const auto last = columns_.begin() + static_cast<std::ptrdiff_t>(begin_[static_cast<std::size_t>(row) + 1]);
  return static_cast<std::size_t>(std::lower_bound(first, last, column) - columns_.begin());
}

std::vector<Twist> damping_of(const BlockPattern& pattern, const BlockSystem& system, double damping, double floor) {
  std::vector<Twist> result(pattern.node_count());
  double largest = 0;
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = system.blocks[pattern.find(static_cast<int>(i), static_cast<int>(i))].diagonal();
    largest = std::max(largest, result[i].maxCoeff());
  }
  // Without any data at all the diagonal is empty: some number keeps the step finite, namely zero.
  const double least = largest > 0 ? floor * largest : 1.0;
  for (Twist& diagonal : result) diagonal = (damping * diagonal).cwiseMax(least);
  return result;
}

PcgResult solve_pcg(const BlockPattern& pattern, const BlockSystem& system, std::span<const Twist> added,
                    int max_iterations, double tolerance) {
  const std::size_t n = pattern.node_count();
  PcgResult result;
  result.step.assign(n, Twist::Zero());
  std::vector<Block> inverses(n);
  for (std::size_t i = 0; i < n; ++i) {
    Block block = system.blocks[pattern.find(static_cast<int>(i), static_cast<int>(i))];
    block.diagonal() += added[i];
    inverses[i] = block.ldlt().solve(Block::Identity());
    if (!inverses[i].allFinite()) inverses[i] = block.diagonal().cwiseMax(1e-300).cwiseInverse().asDiagonal();
  }
  std::vector<Twist> residual(n);
  std::vector<Twist> preconditioned(n);
  std::vector<Twist> image(n);
  for (std::size_t i = 0; i < n; ++i) {
    residual[i] = -system.gradient[i];
    preconditioned[i] = inverses[i] * residual[i];
  }
  std::vector<Twist> direction = preconditioned;
  double energy = dot(residual, preconditioned);
  const double enough = energy * tolerance * tolerance;
  while (result.iterations < max_iterations && energy > enough && energy > 0) {
    multiply(pattern, system, direction, image);
    for (std::size_t i = 0; i < n; ++i) image[i] += added[i].cwiseProduct(direction[i]);
    const double curvature = dot(direction, image);
    if (!(curvature > 0) || !std::isfinite(energy / curvature)) break;
    const double length = energy / curvature;
    for (std::size_t i = 0; i < n; ++i) {
      result.step[i] += length * direction[i];
      residual[i] -= length * image[i];
      preconditioned[i].noalias() = inverses[i] * residual[i];
    }
    const double next = dot(residual, preconditioned);
    const double share = next / energy;
    for (std::size_t i = 0; i < n; ++i) direction[i] = preconditioned[i] + share * direction[i];
    energy = next;
    ++result.iterations;
  }
  return result;
}

std::vector<Twist> solve_dense(const BlockPattern& pattern, const BlockSystem& system, std::span<const Twist> added) {
  const std::size_t n = pattern.node_count();
  const auto size = static_cast<Eigen::Index>(6 * n);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd right(size);
  for (std::size_t row = 0; row < n; ++row) {
    const auto at = static_cast<Eigen::Index>(6 * row);
    for (std::size_t b = pattern.row_begin(row); b < pattern.row_end(row); ++b) {
      matrix.block<6, 6>(at, 6 * static_cast<Eigen::Index>(pattern.column(b))) = system.blocks[b];
    }
    matrix.diagonal().segment<6>(at) += added[row];
    right.segment<6>(at) = -system.gradient[row];
  }
  const Eigen::VectorXd solution = matrix.ldlt().solve(right);
  std::vector<Twist> step(n);
  for (std::size_t i = 0; i < n; ++i) step[i] = solution.segment<6>(static_cast<Eigen::Index>(6 * i));
  return step;
}

double model_change(const BlockPattern& pattern, const BlockSystem& system, std::span<const Twist> step) {
  std::vector<Twist> image(step.size());
  multiply(pattern, system, step, image);
  return dot(system.gradient, step) + 0.5 * dot(image, step);
}

} // namespace kinora::tracking
