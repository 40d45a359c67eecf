#include "tracking/solver/pcg.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tracking/solver/pcg_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

#ifndef KINORA_TRACKING_PCG_ONCE
#define KINORA_TRACKING_PCG_ONCE
namespace kinora::tracking {

/// What conjugate gradients start from, one item for each node.
struct PcgProblem {
  const BlockPattern& pattern;
  const Block* blocks;
  std::span<const Block> inverses;    ///< of the diagonal blocks, damped
  std::span<const PaddedTwist> added; ///< to the diagonal
  std::span<const PaddedTwist> right_side;
};

} // namespace kinora::tracking
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora::tracking::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kPadded = std::tuple_size_v<PaddedTwist>;
using Numbers = hn::CappedTag<float, kPadded>;
using V = hn::Vec<Numbers>;
constexpr std::size_t kParts = kPadded / hn::MaxLanes(Numbers()); ///< vectors to a twist

/// A twist in vectors.
struct Lanes {
  V parts[kParts];

  static HWY_INLINE Lanes zero() {
    Lanes result;
    for (V& part : result.parts) part = hn::Zero(Numbers());
    return result;
  }
  static HWY_INLINE Lanes load(const PaddedTwist& from) {
    const Numbers d;
    Lanes result;
    for (std::size_t i = 0; i < kParts; ++i) result.parts[i] = hn::LoadU(d, from.data() + i * hn::MaxLanes(d));
    return result;
  }
  HWY_INLINE void store(PaddedTwist& to) const {
    const Numbers d;
    for (std::size_t i = 0; i < kParts; ++i) hn::StoreU(parts[i], d, to.data() + i * hn::MaxLanes(d));
  }
  HWY_INLINE void add_product(V factor, const Lanes& other) {
    for (std::size_t i = 0; i < kParts; ++i) parts[i] = hn::MulAdd(factor, other.parts[i], parts[i]);
  }
  HWY_INLINE void add_products(const Lanes& a, const Lanes& b) {
    for (std::size_t i = 0; i < kParts; ++i) parts[i] = hn::MulAdd(a.parts[i], b.parts[i], parts[i]);
  }
  HWY_INLINE void add(const Lanes& other) {
    for (std::size_t i = 0; i < kParts; ++i) parts[i] = hn::Add(parts[i], other.parts[i]);
  }
  HWY_INLINE float sum() const {
    V all = parts[0];
    for (std::size_t i = 1; i < kParts; ++i) all = hn::Add(all, parts[i]);
    return hn::GetLane(hn::SumOfLanes(Numbers(), all));
  }
};

/// Two sums, of even and odd columns, so that they do not wait for each other.
HWY_INLINE void add_block_product(const Block& block, const PaddedTwist& x, Lanes& even, Lanes& odd) {
  const Numbers d;
  for (std::size_t c = 0; c < block.columns.size(); c += 2) {
    even.add_product(hn::Set(d, x[c]), Lanes::load(block.columns[c]));
    odd.add_product(hn::Set(d, x[c + 1]), Lanes::load(block.columns[c + 1]));
  }
}

HWY_INLINE Lanes product(const Block& block, const PaddedTwist& x) {
  Lanes even = Lanes::zero();
  Lanes odd = Lanes::zero();
  add_block_product(block, x, even, odd);
  even.add(odd);
  return even;
}

/// One row of the matrix times x.
HWY_INLINE Lanes row_product(const BlockPattern& pattern, const Block* blocks, std::size_t row, const PaddedTwist* x) {
  Lanes even = Lanes::zero();
  Lanes odd = Lanes::zero();
  const int* columns = pattern.columns().data();
  for (std::size_t b = pattern.row_begin(row); b < pattern.row_end(row); ++b) {
    add_block_product(blocks[b], x[columns[b]], even, odd);
  }
  even.add(odd);
  return even;
}

int conjugate_gradients(const PcgProblem& problem, int max_iterations, double tolerance, PaddedTwist* step) {
  const Numbers d;
  const std::size_t n = problem.pattern.node_count();
  std::vector<PaddedTwist> residual(problem.right_side.begin(), problem.right_side.end());
  std::vector<PaddedTwist> preconditioned(n);
  std::vector<PaddedTwist> image(n);
  Lanes sum = Lanes::zero();
  for (std::size_t i = 0; i < n; ++i) {
    const Lanes z = product(problem.inverses[i], residual[i]);
    z.store(preconditioned[i]);
    sum.add_products(Lanes::load(residual[i]), z);
    Lanes::zero().store(step[i]);
  }
  std::vector<PaddedTwist> direction = preconditioned;
  float energy = sum.sum();
  const double enough = static_cast<double>(energy) * tolerance * tolerance;
  int iterations = 0;
  while (iterations<max_iterations&& static_cast<double>(energy)> enough && energy > 0) {
    sum = Lanes::zero();
    for (std::size_t i = 0; i < n; ++i) {
      Lanes product_of_row = row_product(problem.pattern, problem.blocks, i, direction.data());
      const Lanes along = Lanes::load(direction[i]);
      product_of_row.add_products(Lanes::load(problem.added[i]), along);
      product_of_row.store(image[i]);
      sum.add_products(along, product_of_row);
    }
    const float curvature = sum.sum();
    const float length = energy / curvature;
    if (!(curvature > 0) || !std::isfinite(length)) break;
    sum = Lanes::zero();
    for (std::size_t i = 0; i < n; ++i) {
      Lanes moved = Lanes::load(step[i]);
      moved.add_product(hn::Set(d, length), Lanes::load(direction[i]));
      moved.store(step[i]);
      Lanes left = Lanes::load(residual[i]);
      left.add_product(hn::Set(d, -length), Lanes::load(image[i]));
      left.store(residual[i]);
      const Lanes z = product(problem.inverses[i], residual[i]);
      z.store(preconditioned[i]);
      sum.add_products(left, z);
    }
    const float next = sum.sum();
    const V share = hn::Set(d, next / energy);
    for (std::size_t i = 0; i < n; ++i) {
      Lanes onwards = Lanes::load(preconditioned[i]);
      onwards.add_product(share, Lanes::load(direction[i]));
      onwards.store(direction[i]);
    }
    energy = next;
    ++iterations;
  }
  return iterations;
}

/// xᵀHx
double quadratic_form(const BlockPattern& pattern, const Block* blocks, const PaddedTwist* x) {
  Lanes sum = Lanes::zero();
  for (std::size_t i = 0; i < pattern.node_count(); ++i) {
    sum.add_products(Lanes::load(x[i]), row_product(pattern, blocks, i, x));
  }
  return static_cast<double>(sum.sum());
}

} // namespace kinora::tracking::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::tracking {
namespace {

HWY_EXPORT(conjugate_gradients);
HWY_EXPORT(quadratic_form);

constexpr std::size_t kNodesPerChunk = 64;

PaddedTwist padded(const Twist& twist) {
  PaddedTwist result{};
  Eigen::Map<Eigen::Matrix<float, 6, 1>>(result.data()) = twist.cast<float>();
  return result;
}

Block inverse_of(const Block& diagonal, const Twist& added) {
  Matrix6d damped = diagonal.matrix().cast<double>();
  damped.diagonal() += added;
  Matrix6d inverse = damped.ldlt().solve(Matrix6d::Identity());
  if (!inverse.allFinite()) inverse = damped.diagonal().cwiseMax(1e-30).cwiseInverse().asDiagonal();
  Block result;
  result.matrix() = inverse.cast<float>();
  return result;
}

} // namespace

PcgResult solve_pcg(const BlockPattern& pattern, const BlockSystem& system, std::span<const Twist> added,
                    int max_iterations, double tolerance) {
  const std::size_t n = pattern.node_count();
  std::vector<Block> inverses(n);
  std::vector<PaddedTwist> on_diagonal(n);
  std::vector<PaddedTwist> right_side(n);
  parallel_for(n, kNodesPerChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      inverses[i] = inverse_of(system.blocks[pattern.diagonal(i)], added[i]);
      on_diagonal[i] = padded(added[i]);
      right_side[i] = padded(-system.gradient[i]);
    }
  });
  std::vector<PaddedTwist> step(n);
  PcgResult result;
  result.iterations = HWY_DYNAMIC_DISPATCH(conjugate_gradients)(
      {pattern, system.blocks.data(), inverses, on_diagonal, right_side}, max_iterations, tolerance, step.data());
  result.step.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    result.step[i] = Eigen::Map<const Eigen::Matrix<float, 6, 1>>(step[i].data()).cast<double>();
  }
  return result;
}

double model_change(const BlockPattern& pattern, const BlockSystem& system, std::span<const Twist> step) {
  std::vector<PaddedTwist> x(step.size());
  double linear_term = 0;
  for (std::size_t i = 0; i < step.size(); ++i) {
    x[i] = padded(step[i]);
    linear_term += system.gradient[i].dot(step[i]);
  }
  return linear_term + 0.5 * HWY_DYNAMIC_DISPATCH(quadratic_form)(pattern, system.blocks.data(), x.data());
}

} // namespace kinora::tracking
#endif
