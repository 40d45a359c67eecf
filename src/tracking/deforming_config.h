// How a layer that deforms is searched for, grown, split, found again and followed back (deforming_tracker.h).
#pragma once

#include <cstddef>

#include "tracking/node_flow.h"

namespace kinora::tracking {

/// When a layer is looked for elsewhere than where it is expected.
struct DeformingSearchConfig {
  double max_free_space_share = 0.25; ///< of the model: above, other places are tried as well
  double min_correlation = 0.4;       ///< of the texture: below, likewise
  double jump = 0.05;                 ///< metres beyond what is expected: from less, alignment finds back
  double clearly_better = 0.1;        ///< share of the surface that would face the camera in addition
  int passes = 3;                     ///< of alignment from where it was found
};

/// Limbs whose nodes are not where the bones have them.
struct LimbPlacementConfig {
  double distance = 0.03;      ///< metres between both places: nearer, either leads to the other
  double clearly_better = 0.1; ///< share of the bones' surface that would face the camera in addition
  double weight_share = 0.5;   ///< of a point's weights on the bones: above, it is theirs
};

/// How the graph and the model grow. Lengths in units of the nodes' spacing, but where metres are said.
struct GraphGrowthConfig {
  double weight_radius = 1.1;
  double influence_radius = 2.5;   ///< so that a surface between nodes, and what lies before it, moves with them
  double sample_spacing = 1.0 / 3; ///< grid of the thinned surface
  float min_views = 2.5F;          ///< that a surface must have been seen in before it gets nodes
  double unfold_reach = 0.03;      ///< metres from the model to what is fused
  int piece_frames = 8;            ///< in a row that show a piece apart before it is taken into the model
  double piece_step = 0.08;        ///< metres that a piece may go from frame to frame
  std::size_t piece_cells = 12;    ///< that a piece has at least
  double piece_jump = 0.03;        ///< metres between a piece and the model
};

/// When surfaces that touch in canonical space are taken apart. Lengths in units of the nodes' spacing.
struct TopologyChangeConfig {
  double near = 2;           ///< nodes that move the same points
  double apart = 1;          ///< by so much farther away from each other, they no longer do
  double max_stretch = 1.3;  ///< of an edge that holds
  double pull = 0.3;         ///< of a node towards where it is, against one edge: what is mistaken stands alone
  std::size_t min_pairs = 3; ///< that part; fewer may be mistaken
  std::size_t min_ratio = 2; ///< as many pairs part as come together, or else the other pose is no better
};

/// How a lost layer is found by the poses that it was seen in.
struct RelocalisationConfig {
  std::size_t ranked_points = 1000; ///< of the surface, that rank the poses
  std::size_t aligned_poses = 3;
};

/// How what was found late is followed back to where it was before. What is hidden lies near to what is seen, and is
/// not it; and it stays where its neighbours would have it unless the camera says otherwise.
struct BackwardSmoothingConfig {
  double guessed_share = 0.5; ///< of a point's weights on nodes that were found later: above, it takes part
  double plane_gate = 0.05;   ///< metres, in place of the solver's
  double prior_sigma = 0.007; ///< metres, likewise: of a place that was guessed from neighbours
};

} // namespace kinora::tracking
