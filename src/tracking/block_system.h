// Sparse normal equations of many rigid bodies: one block of 6×6 for each pair of nodes that some residual ties.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/se3.h"

namespace kinora::tracking {

using Block = Eigen::Matrix<double, 6, 6>;

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
  /// Position of a block that exists.
  std::size_t find(int row, int column) const;

private:
  std::vector<std::size_t> begin_;
  std::vector<int> columns_;
};

/// Hessian · step = −gradient. Blocks lie as the pattern says; plain data.
struct BlockSystem {
  std::vector<Block> blocks;
  std::vector<Twist> gradient;
};

struct PcgResult {
  std::vector<Twist> step;
  int iterations = 0;
};

/// Diagonal that damping adds to each node: damping · diag(H), and at least `floor` of that node's largest entry.
std::vector<Twist> damping_of(const BlockPattern& pattern, const BlockSystem& system, double damping, double floor);

/// Solves (H + diag(added)) · step = −gradient by conjugate gradients with block-Jacobi preconditioning, down to
/// `tolerance` of the gradient's preconditioned norm. Finite for finite input: stops where curvature vanishes.
PcgResult solve_pcg(const BlockPattern& pattern, const BlockSystem& system, std::span<const Twist> added,
                    int max_iterations, double tolerance);

/// The same by a dense LDLᵀ: the reference that tests hold the other against. Cubic in the number of nodes.
std::vector<Twist> solve_dense(const BlockPattern& pattern, const BlockSystem& system, std::span<const Twist> added);

/// Change of the quadratic model over a step: gᵀs + ½ sᵀHs (without damping).
double model_change(const BlockPattern& pattern, const BlockSystem& system, std::span<const Twist> step);

} // namespace kinora::tracking
