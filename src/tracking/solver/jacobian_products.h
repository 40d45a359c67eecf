// The part of the normal equations that costs most: products of the derivatives of the layer's points, vectorised with
// Highway and chosen at run time for the processor. tests/tracking/solver/jacobian_products_test.cpp keeps them equal
// to plain loops.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "motion/skinning/deformation_graph.h"
#include "tracking/solver/block_system.h"

namespace kinora::tracking {

/// A point's residuals, times the root of their weights, and their derivatives by the twists of its nodes.
struct PointJacobians {
  static constexpr std::size_t kRows = 2;
  using Row = PaddedTwist;
  bool empty = true;
  std::array<float, kRows> residuals;
  std::array<std::array<Row, kRows>, motion::Influence::kMax> by_node;
};

/// A point that a node takes part in.
struct PointIncidence {
  static constexpr std::uint32_t kNone = ~0U;
  std::uint32_t point;
  std::uint32_t slot; ///< of the node among the point's
  /// For each of the point's nodes, which block of the node's row of the system the two share; kNone: none that is
  /// wanted.
  std::array<std::uint32_t, motion::Influence::kMax> blocks;
};

/// Adds JᵀJ of one node with each that shares a point with it, in the order of `uses`: column c, row r of a block is
/// the derivative by number c of the other's twist times that by number r of the node's own.
void add_jacobian_products(std::span<const PointIncidence> uses, std::span<const PointJacobians> points,
                           std::span<Block> blocks, PointJacobians::Row& gradient);

} // namespace kinora::tracking
