// Since when parts of a deforming layer are there: what came into view late is not drawn before.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "motion/skinning/deformation_graph.h"

namespace kinora::motion {

/// Nodes that are not there yet; empty: all are.
using UnbornNodes = std::vector<bool>;

/// Whether a point is not there yet that these nodes move: more than half of what moves it is not born.
bool is_unborn(const Influence& influence, const UnbornNodes& unborn);

/// The frame at which each node of a graph is born. Immutable; may be shared by threads.
class NodeBirths {
public:
  /// All nodes are there from the first frame on.
  NodeBirths() = default;
  /// One frame for each node.
  explicit NodeBirths(std::vector<std::uint32_t> frames);

  bool are_at_the_start() const { return frames_.empty(); }
  /// Of each node; empty if all are at the start.
  const std::vector<std::uint32_t>& frames() const { return frames_; }
  /// Those that are born after a whole or fractional frame, not negative, of which a fraction counts as the frame
  /// before it.
  UnbornNodes unborn(double frame) const;
  /// The same in a clip that ends earlier: nodes that are born later are never born in it.
  NodeBirths in_first_frames(std::uint32_t count) const;
  /// The frame from which on a point that these nodes move is there.
  std::uint32_t birth_of(const Influence& influence) const;

  friend bool operator==(const NodeBirths&, const NodeBirths&) = default;

private:
  std::vector<std::uint32_t> frames_;
};

} // namespace kinora::motion
