#include "tracking/solver/block_system.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace kinora::tracking {
BlockPattern::BlockPattern(std::size_t nodes, std::span<const Pair> pairs) : begin_(nodes + 1), diagonals_(nodes) {
  std::vector<std::size_t> ends(nodes, 1);
  for (const Pair& pair : pairs) {
    ++ends[static_cast<std::size_t>(pair.a)];
    ++ends[static_cast<std::size_t>(pair.b)];
  }
  for (std::size_t i = 1; i < nodes; ++i) ends[i] += ends[i - 1];
  std::vector<int> all(nodes > 0 ? ends.back() : 0); // from the ends of the rows to their beginnings
  for (std::size_t i = 0; i < nodes; ++i) all[--ends[i]] = static_cast<int>(i);
  for (const Pair& pair : pairs) {
    all[--ends[static_cast<std::size_t>(pair.a)]] = pair.b;
    all[--ends[static_cast<std::size_t>(pair.b)]] = pair.a;
  }
  columns_.reserve(all.size());
  for (std::size_t i = 0; i < nodes; ++i) {
    const auto row = all.begin() + static_cast<std::ptrdiff_t>(ends[i]);
    const auto end = i + 1 < nodes ? all.begin() + static_cast<std::ptrdiff_t>(ends[i + 1]) : all.end();
    std::sort(row, end);
    columns_.insert(columns_.end(), row, std::unique(row, end));
    begin_[i + 1] = columns_.size();
  }
  transposed_.resize(columns_.size());
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1); // block of each row whose transpose comes next
  for (std::size_t i = 0; i < nodes; ++i) {
    diagonals_[i] = next[i];
    for (std::size_t b = next[i]; b < begin_[i + 1]; ++b) {
      const std::size_t other = next[static_cast<std::size_t>(columns_[b])]++;
      transposed_[b] = other;
      transposed_[other] = b;
    }
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
    result[i] = system.blocks[pattern.diagonal(i)].matrix().diagonal().cast<double>();
    largest = std::max(largest, result[i].maxCoeff());
  }
  // Without any data at all the diagonal is empty: some number keeps the step finite, namely zero.
  const double least = largest > 0 ? floor * largest : 1.0;
  for (Twist& diagonal : result) diagonal = (damping * diagonal).cwiseMax(least);
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
      matrix.block<6, 6>(at, 6 * static_cast<Eigen::Index>(pattern.column(b))) =
          system.blocks[b].matrix().cast<double>();
    }
    matrix.diagonal().segment<6>(at) += added[row];
    right.segment<6>(at) = -system.gradient[row];
  }
  const Eigen::VectorXd solution = matrix.ldlt().solve(right);
  std::vector<Twist> step(n);
  for (std::size_t i = 0; i < n; ++i) step[i] = solution.segment<6>(static_cast<Eigen::Index>(6 * i));
  return step;
}

} // namespace kinora::tracking
