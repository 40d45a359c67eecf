// Where the picture says that nodes have gone since the last view: the texture about each is looked for around where it
// is expected, and depth lifts what is found. For cloth that slips along itself and limbs without bones, whose geometry
// looks the same wherever they are.
// Source: block matching by normalised cross-correlation (Lewis, "Fast Normalized Cross-Correlation", 1995), made
// smooth by a median among neighbours of the graph.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "motion/skinning/blended_motion.h"
#include "tracking/model/surface_graph.h"
#include "tracking/view/layer_view.h"

namespace kinora::tracking {

struct BlockMatchingConfig {
  int reach = 12;                 ///< of the search, in pixels of half the view's resolution
  double min_correlation = 0.8;   ///< of the same texture
  double min_gain = 0.15;         ///< over that where it is expected
  double surface_distance = 0.02; ///< metres between a node and the surface that shows it, at most
  std::size_t min_matches = 3;    ///< a node's and its neighbours'
  double min_step = 0.008;        ///< metres: the solver finds less by itself
};

/// For each node, metres in the present camera to add to where it is `expected`; zero where the texture is found there,
/// or tells nothing. `then`: nodes in the last view. A node whose texture is where it is expected costs
/// one comparison.
/// Deterministic for any number of threads.
std::vector<Eigen::Vector3d> match_blocks(const LayerView& last, const motion::NodeStates& then, const LayerView& now,
                                          const motion::NodeStates& expected, std::span<const GraphEdge> edges,
                                          const BlockMatchingConfig& config = {});

} // namespace kinora::tracking
