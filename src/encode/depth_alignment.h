// Where a finished layer is in a frame that it was not made of, as the frame's depth alone tells: the surface that its
// field shows at a guess is aligned with what is measured, point to plane (tracking::DeformingProblem).
#pragma once

#include <optional>
#include <vector>

#include "fields/rendering/renderer.h"
#include "motion/warp.h"
#include "tracking/model/surface_graph.h"
#include "tracking/view/layer_view.h"

namespace kinora::encode {

/// How the nodes of a layer that deforms hang together; without edges one that does not.
struct LayerStiffness {
  std::vector<tracking::GraphEdge> edges;
  double node_spacing = 0; ///< metres
};

/// The warp nearer to what `view` shows of the layer; nothing if the view does not support one better than the guess.
/// `drawn`: the layer alone at the guess, seen by `camera`, with normals. Neither colour nor silhouettes are looked at.
/// The guess holds where depth tells nothing. Same bits for any number of threads.
std::optional<motion::Warp> align_by_depth(const fields::Picture& drawn, const Camera& camera,
                                           const motion::Warp& guess, const LayerStiffness& stiffness,
                                           const tracking::LayerView& view);

} // namespace kinora::encode
