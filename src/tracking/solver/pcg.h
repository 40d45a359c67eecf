// Preconditioned conjugate gradients (PCG) on block-sparse normal equations, in single precision; products with blocks
// are vectorised with Highway and chosen at run time for the processor.
// Source: Shewchuk, "An Introduction to the Conjugate Gradient Method Without the Agonizing Pain", 1994.
#pragma once

#include <span>
#include <vector>

#include "tracking/solver/block_system.h"

namespace kinora::tracking {

struct PcgResult {
  std::vector<Twist> step;
  int iterations = 0;
};

/// Solves (H + diag(added)) · step = −gradient by conjugate gradients in single precision with block-Jacobi
/// preconditioning, down to `tolerance` of the gradient's preconditioned norm. Finite for finite input: stops where
/// curvature vanishes. Same bits for any number of threads.
PcgResult solve_pcg(const BlockPattern& pattern, const BlockSystem& system, std::span<const Twist> added,
                    int max_iterations, double tolerance);

/// Change of the quadratic model over a step: gᵀs + ½ sᵀHs (without damping).
double model_change(const BlockPattern& pattern, const BlockSystem& system, std::span<const Twist> step);

} // namespace kinora::tracking
