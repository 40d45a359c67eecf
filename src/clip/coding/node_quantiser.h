// Transforms of a deformation graph's nodes as integers, and their prediction from what is already known. All of it is
// exact: a reader on any machine predicts what the writer did. docs/container.md specifies it.
#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "core/dual_quaternion.h"

namespace kinora::clip {

/// Positions of nodes in canonical space are multiples of 2⁻²⁰ m, those in the world of 2⁻¹³ m = 0.12 mm.
inline constexpr double kRestUnits = 1 << 20;
inline constexpr double kLiveUnits = 1 << 13;
/// The largest component of a rotation's quaternion is this; the others are multiples of 1/2048 of it: steps of 2⁻¹⁰
/// rad and less.
inline constexpr std::int32_t kQuaternionUnits = 1 << 11;
/// Nodes are no farther than this from the origin for each axis: 2¹⁰ m in canonical space, 2¹⁴ m in the world.
inline constexpr std::int32_t kFarthestRest = 1 << 30;
inline constexpr std::int32_t kFarthestLive = 1 << 27;

using RestPosition = std::array<std::int32_t, 3>; ///< in 1/kRestUnits

/// Where a node is and how it is turned, at one instant.
struct NodeState {
  std::array<std::int32_t, 3> position{}; ///< in the world, in 1/kLiveUnits
  std::array<std::int32_t, 4> rotation{kQuaternionUnits, 0, 0,
                                       0}; ///< w x y z; the first of the largest is kQuaternionUnits
};

/// A state's numbers are multiples of these powers of two: position in 1/kLiveUnits, rotation in 1/kQuaternionUnits.
struct NodeSteps {
  std::int32_t position = 1;
  std::int32_t rotation = 1;
};
inline constexpr NodeSteps kFineSteps{1, 1};
inline constexpr NodeSteps kCoarseSteps{4, 8};

std::uint64_t squared_distance(const RestPosition& a, const RestPosition& b);

/// Throws Error(kFailure) if a position is not finite or too far away.
RestPosition quantise_rest(const Eigen::Vector3d& canonical);
std::vector<RestPosition> quantise_rest(std::span<const Eigen::Vector3d> canonical);
Eigen::Vector3d dequantise(const RestPosition& rest);

/// Throws Error(kFailure) if the transform is not finite, not of unit length, or carries the node too far away.
/// quantise(dequantise(s)) = s by the steps of s, and by finer ones that divide them.
NodeState quantise(const DualQuaternion& node_to_world, const RestPosition& rest, const NodeSteps& steps);
inline bool is_multiple_of(const NodeState& state, const NodeSteps& steps) {
  const auto& [p, r] = state;
  return ((p[0] | p[1] | p[2]) & (steps.position - 1)) == 0 &&
         ((r[0] | r[1] | r[2] | r[3]) & (steps.rotation - 1)) == 0;
}
DualQuaternion dequantise(const NodeState& state, const RestPosition& rest);

/// The first of the components that are largest in size.
template <class Integer> std::size_t largest_component(const std::array<Integer, 4>& rotation) {
  std::size_t largest = 0;
  for (std::size_t c = 1; c < 4; ++c) {
    if (std::abs(rotation[c]) > std::abs(rotation[largest])) largest = c;
  }
  return largest;
}

/// a / b to the nearest integer, halves up; b is not 0.
inline std::int64_t rounded_quotient(std::int64_t a, std::int64_t b) {
  if (b < 0) {
    a = -a;
    b = -b;
  }
  a += b / 2;
  const std::int64_t quotient = a / b;
  return a % b < 0 ? quotient - 1 : quotient;
}

using WideQuaternion = std::array<std::int64_t, 4>; ///< w x y z, of any length

/// How a node turned: what nodes beside it have in common when they are predicted from it.
struct NodeTurn {
  NodeTurn() = default; ///< of no meaning yet
  NodeTurn(const NodeState& before, const NodeState& after);

  WideQuaternion rotation;            ///< of a length from 2²² to 2²⁴
  std::array<std::int64_t, 9> matrix; ///< of the rotation, roughly, times `scale`; row-major
  std::int64_t scale;                 ///< from 2²⁶ to 2³⁰
};

/// What the nodes around one expect of it.
struct NodePrediction {
  static constexpr std::size_t kMax = 2;
  std::array<std::int32_t, 3> position{};
  std::size_t count = 0;                      ///< of rotations, at least 1
  std::array<WideQuaternion, kMax> rotations; ///< by each neighbour's account, the nearest first

  /// The component that should be the largest.
  std::size_t face() const { return largest_component(rotations[0]); }
  /// Component `c`, if component `face` is kQuaternionUnits.
  std::int32_t component(std::size_t face, std::size_t c) const;
};

/// Predicts nodes one after the other from a reference, which knows all of them, and the nodes before. Immutable.
class NodePredictor {
public:
  explicit NodePredictor(std::span<const RestPosition> rest);

  /// The nodes as they are in canonical space: the reference of a key payload.
  const std::vector<NodeState>& rest() const { return rest_; }
  /// Every node once, each near one that comes before it.
  const std::vector<std::uint32_t>& order() const { return order_; }
  /// Those nearest to node `i` among the nodes before it, nearest first; at most NodePrediction::kMax.
  std::span<const std::uint32_t> neighbours(std::size_t i) const {
    return std::span(neighbours_[i].nodes).first(neighbours_[i].count);
  }
  /// Of node `i`; of those before it in the order the states are known in `now`, and how they turned from `reference`.
  NodePrediction predict(std::size_t i, std::span<const NodeState> reference, std::span<const NodeState> now,
                         std::span<const NodeTurn> turns) const;

private:
  struct Neighbours {
    std::size_t count = 0;
    std::array<std::uint32_t, NodePrediction::kMax> nodes{};
    std::array<std::uint64_t, NodePrediction::kMax> squared_distances{};

    void offer(std::uint32_t node, std::uint64_t squared_distance);
  };
  void choose_order(std::span<const RestPosition> rest);

  std::vector<NodeState> rest_;
  std::vector<std::uint32_t> order_;
  std::vector<Neighbours> neighbours_; // of each node: the nearest among those before it, nearest first
};

} // namespace kinora::clip
