// Nodes that a deformation graph has got, and how they moved before anybody knew of them, as far as the graph can tell.
#pragma once

#include <cstddef>
#include <vector>

#include "motion/skinning/deformation_graph.h"

namespace kinora::tracking {

/// New nodes in the order of their numbers: first those in `attached`, then those in `grown`.
struct GraphGrowth {
  std::vector<std::size_t> attached;    ///< each has gone along with this one node, which is older
  std::vector<motion::Influence> grown; ///< each has moved as the surface about it did, by nodes that are older
};

} // namespace kinora::tracking
