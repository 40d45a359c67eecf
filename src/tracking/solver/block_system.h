// Sparse normal equations of many rigid bodies: one block of 6×6 for each pair of nodes that some residual ties. Blocks
// are in single precision.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/se3.h"

namespace kinora::tracking {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Six numbers and zeros, as lanes read them.
using PaddedTwist = std::array<float, 8>;

/// 6×6 numbers, column by column.
struct Block {
  using Matrix = Eigen::Map<Eigen::Matrix<float, 6, 6>, 0, Eigen::OuterStride<8>>;
  using ConstMatrix = Eigen::Map<const Eigen::Matrix<float, 6, 6>, 0, Eigen::OuterStride<8>>;
  std::array<PaddedTwist, 6> columns{};

  Matrix matrix() { return Matrix(columns[0].data()); }
  ConstMatrix matrix() const { return ConstMatrix(columns[0].data()); }
};

/// Which pairs of nodes have a block. Symmetric, with the diagonal; columns of a row ascend.
class BlockPattern {
public:
  struct Pair {
    int a, b;
  };
  BlockPattern() = default;
  /// `pairs` may repeat, in any order; indices lie in [0, nodes).
  BlockPattern(std::size_t nodes, std::span<const Pair> pairs);

  std::size_t node_count() const { return begin_.empty() ? 0 : begin_.size() - 1; }
  std::size_t block_count() const { return columns_.size(); }
  std::size_t row_begin(std::size_t row) const { return begin_[row]; }
  std::size_t row_end(std::size_t row) const { return begin_[row + 1]; }
  int column(std::size_t block) const { return columns_[block]; }
  std::size_t diagonal(std::size_t row) const { return diagonals_[row]; }
  /// The block of the same two nodes the other way round.
  std::size_t transposed(std::size_t block) const { return transposed_[block]; }
  /// Columns of all rows' blocks, row after row.
  std::span<const int> columns() const { return columns_; }
  std::span<const std::size_t> row_begins() const { return begin_; }
  /// Position of a block that exists.
  std::size_t find(int row, int column) const;

private:
  std::vector<std::size_t> begin_;
  std::vector<int> columns_;
  std::vector<std::size_t> diagonals_;
  std::vector<std::size_t> transposed_;
};

/// Hessian · step = −gradient. Blocks lie as the pattern says; plain data.
struct BlockSystem {
  std::vector<Block> blocks;
  std::vector<Twist> gradient;
};

/// Diagonal that damping adds to each node: damping · diag(H), and at least `floor` of that node's largest entry.
std::vector<Twist> damping_of(const BlockPattern& pattern, const BlockSystem& system, double damping, double floor);

/// Solves (H + diag(added)) · step = −gradient by a dense LDLᵀ: the reference that tests hold solve_pcg() against.
/// Cubic in the number of nodes.
std::vector<Twist> solve_dense(const BlockPattern& pattern, const BlockSystem& system, std::span<const Twist> added);

} // namespace kinora::tracking
